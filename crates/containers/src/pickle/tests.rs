//! Pickles as Python writes them, and as nobody does.

use crate::pickle::{Array, ArrayError, Id, Pickle, PickleValue, Sparse};
use proptest::prelude::*;

#[test]
fn a_dictionary_reads_as_python_wrote_it() {
    // pickle.dumps({"a": [1, -2, 3.5, None], "b": (True, 2**40)}, protocol=2)
    let bytes =
        b"\x80\x02}q\x00(X\x01\x00\x00\x00aq\x01]q\x02(K\x01J\xfe\xff\xff\xffG@\x0c\x00\x00\
\x00\x00\x00\x00NeX\x01\x00\x00\x00bq\x03\x88\x8a\x06\x00\x00\x00\x00\x00\x01\x86q\x04u.tail";
    let pickle = Pickle::read(bytes, 0).unwrap();
    assert_eq!(&bytes[pickle.end()..], b"tail");
    let value = |id: &Id| pickle.node(*id).clone();
    let list = pickle.sequence(pickle.get(pickle.root(), "a").unwrap()).unwrap();
    let list: Vec<_> = list.iter().map(value).collect();
    assert_eq!(
        list,
        [PickleValue::Int(1), PickleValue::Int(-2), PickleValue::Float(3.5), PickleValue::None]
    );
    let tuple = pickle.sequence(pickle.get(pickle.root(), "b").unwrap()).unwrap();
    let tuple: Vec<_> = tuple.iter().map(value).collect();
    assert_eq!(tuple, [PickleValue::Bool(true), PickleValue::Int(1 << 40)]);
}

#[test]
fn unknown_classes_are_kept_unopened() {
    // A subclass of dict, filled with one entry and given a state; then its class as a key.
    let bytes =
        b"\x80\x02}(X\x01\x00\x00\x00hcsome.where\nThing\n)\x81X\x01\x00\x00\x00kK\x07s}bcsome\
.where\nThing\nK\x01u.";
    let pickle = Pickle::read(bytes, 0).unwrap();
    let thing = pickle.get(pickle.root(), "h").unwrap();
    assert_eq!(pickle.get(thing, "k").and_then(|id| pickle.size(id)), Some(7));
}

#[test]
fn errors_name_the_byte() {
    let error = |bytes: &[u8]| Pickle::read(bytes, 0).unwrap_err().to_string();
    assert_eq!(error(b"\x80\x02K"), "pickle, byte 2: the file ends here");
    assert_eq!(error(b"\x80\x02\xff"), "pickle, byte 2: unknown opcode 0xff");
    assert_eq!(error(b"h\x05"), "pickle, byte 0: value 5 was never stored");
    assert_eq!(error(b"X\xff\xff\xff\x7f"), "pickle, byte 0: the file ends here");
}

proptest! {
    #[test]
    fn no_bytes_make_the_reader_panic(bytes in prop::collection::vec(any::<u8>(), 0..200)) {
        let _ = Pickle::read(&bytes, 0);
    }

    #[test]
    fn no_program_of_valid_opcodes_makes_the_reader_panic(
        ops in prop::collection::vec(prop::sample::select(&b"(012N\x88K\x01]})ae\x85\x86ltdsuRbQq\x00h\x00.IiLFSVPpgo\n'c"[..]), 0..80),
    ) {
        let _ = Pickle::read(&ops, 0);
    }
}

/// `[[1.5, -2, 3], [4, 5, 200]]` column by column, protocol 0 of Python 3.
const COLUMNS_0: &[u8] = b"cnumpy._core.multiarray\n_reconstruct\np0\n(cnumpy\nndarray\np1\n(I0\ntp2\nc_codecs\nencode\np\
3\n(Vb\np4\nVlatin1\np5\ntp6\nRp7\ntp8\nRp9\n(I1\n(I2\nI3\ntp10\ncnumpy\ndtype\np11\n(Vf8\np12\n\
I00\nI01\ntp13\nRp14\n(I3\nV<\np15\nNNNI-1\nI-1\nI0\ntp16\nbI01\ng3\n(V\\u0000\\u0000\\u0000\\\
u0000\\u0000\\u0000\xf8?\\u0000\\u0000\\u0000\\u0000\\u0000\\u0000\x10@\\u0000\\u0000\\u0000\\\
u0000\\u0000\\u0000\\u0000\xc0\\u0000\\u0000\\u0000\\u0000\\u0000\\u0000\x14@\\u0000\\u0000\\u\
0000\\u0000\\u0000\\u0000\x08@\\u0000\\u0000\\u0000\\u0000\\u0000\\u0000i@\np17\ng5\ntp18\nRp1\
9\ntp20\nb.";
/// The same, protocol 2.
const COLUMNS_2: &[u8] = b"\x80\x02cnumpy._core.multiarray\n_reconstruct\nq\x00cnumpy\nndarray\nq\x01K\x00\x85q\x02c_code\
cs\nencode\nq\x03X\x01\x00\x00\x00bq\x04X\x06\x00\x00\x00latin1q\x05\x86q\x06Rq\x07\x87q\x08Rq\x09\
(K\x01K\x02K\x03\x86q\ncnumpy\ndtype\nq\x0bX\x02\x00\x00\x00f8q\x0c\x89\x88\x87q\x0dRq\x0e(K\
\x03X\x01\x00\x00\x00<q\x0fNNNJ\xff\xff\xff\xffJ\xff\xff\xff\xffK\x00tq\x10b\x88h\x03X2\x00\
\x00\x00\x00\x00\x00\x00\x00\x00\xc3\xb8?\x00\x00\x00\x00\x00\x00\x10@\x00\x00\x00\x00\x00\x00\
\x00\xc3\x80\x00\x00\x00\x00\x00\x00\x14@\x00\x00\x00\x00\x00\x00\x08@\x00\x00\x00\x00\x00\x00\
i@q\x11h\x05\x86q\x12Rq\x13tq\x14b.";
/// The same, protocol 5.
const COLUMNS_5: &[u8] = b"\x80\x05\x95\xa6\x00\x00\x00\x00\x00\x00\x00\x8c\x13numpy._core.numeric\x94\x8c\x0b_frombuffer\
\x94\x93\x94(\x960\x00\x00\x00\x00\x00\x00\x00\x00\x00\x00\x00\x00\x00\xf8?\x00\x00\x00\x00\
\x00\x00\x10@\x00\x00\x00\x00\x00\x00\x00\xc0\x00\x00\x00\x00\x00\x00\x14@\x00\x00\x00\x00\x00\
\x00\x08@\x00\x00\x00\x00\x00\x00i@\x94\x8c\x05numpy\x94\x8c\x05dtype\x94\x93\x94\x8c\x02f8\
\x94\x89\x88\x87\x94R\x94(K\x03\x8c\x01<\x94NNNJ\xff\xff\xff\xffJ\xff\xff\xff\xffK\x00t\x94bK\
\x02K\x03\x86\x94\x8c\x01F\x94t\x94R\x94.";
/// The same row by row as `>f4`.
const BIG_ENDIAN: &[u8] = b"\x80\x02cnumpy._core.multiarray\n_reconstruct\nq\x00cnumpy\nndarray\nq\x01K\x00\x85q\x02c_code\
cs\nencode\nq\x03X\x01\x00\x00\x00bq\x04X\x06\x00\x00\x00latin1q\x05\x86q\x06Rq\x07\x87q\x08Rq\x09\
(K\x01K\x02K\x03\x86q\ncnumpy\ndtype\nq\x0bX\x02\x00\x00\x00f4q\x0c\x89\x88\x87q\x0dRq\x0e(K\
\x03X\x01\x00\x00\x00>q\x0fNNNJ\xff\xff\xff\xffJ\xff\xff\xff\xffK\x00tq\x10b\x89h\x03X\x1c\x00\
\x00\x00?\xc3\x80\x00\x00\xc3\x80\x00\x00\x00@@\x00\x00@\xc2\x80\x00\x00@\xc2\xa0\x00\x00CH\
\x00\x00q\x11h\x05\x86q\x12Rq\x13tq\x14b.";
/// `[None, {}]`.
const OBJECTS: &[u8] = b"\x80\x02cnumpy._core.multiarray\n_reconstruct\nq\x00cnumpy\nndarray\nq\x01K\x00\x85q\x02c_code\
cs\nencode\nq\x03X\x01\x00\x00\x00bq\x04X\x06\x00\x00\x00latin1q\x05\x86q\x06Rq\x07\x87q\x08Rq\x09\
(K\x01K\x02\x85q\ncnumpy\ndtype\nq\x0bX\x02\x00\x00\x00O8q\x0c\x89\x88\x87q\x0dRq\x0e(K\x03X\
\x01\x00\x00\x00|q\x0fNNNJ\xff\xff\xff\xffJ\xff\xff\xff\xffK?tq\x10b\x89]q\x11(N}q\x12etq\x13b\
.";
/// `numpy.float64(2.5)`.
const SCALAR: &[u8] = b"\x80\x02cnumpy._core.multiarray\nscalar\nq\x00cnumpy\ndtype\nq\x01X\x02\x00\x00\x00f8q\x02\x89\
\x88\x87q\x03Rq\x04(K\x03X\x01\x00\x00\x00<q\x05NNNJ\xff\xff\xff\xffJ\xff\xff\xff\xffK\x00tq\
\x06bc_codecs\nencode\nq\x07X\x08\x00\x00\x00\x00\x00\x00\x00\x00\x00\x04@q\x08X\x06\x00\x00\
\x00latin1q\x09\x86q\nRq\x0b\x86q\x0cRq\x0d.";
/// `csc_matrix([[0, 1.5, 0], [2, 0, 0]])`.
const COMPRESSED: &[u8] =
    b"\x80\x02cscipy.sparse._csc\ncsc_matrix\nq\x00)\x81q\x01}q\x02(X\x06\x00\x00\x00_shapeq\x03K\
\x02K\x03\x86q\x04X\x08\x00\x00\x00maxprintq\x05K2X\x06\x00\x00\x00indptrq\x06cnumpy._core.mul\
tiarray\n_reconstruct\nq\x07cnumpy\nndarray\nq\x08K\x00\x85q\x09c_codecs\nencode\nq\nX\x01\x00\
\x00\x00bq\x0bX\x06\x00\x00\x00latin1q\x0c\x86q\x0dRq\x0e\x87q\x0fRq\x10(K\x01K\x04\x85q\x11cn\
umpy\ndtype\nq\x12X\x02\x00\x00\x00i4q\x13\x89\x88\x87q\x14Rq\x15(K\x03X\x01\x00\x00\x00<q\x16\
NNNJ\xff\xff\xff\xffJ\xff\xff\xff\xffK\x00tq\x17b\x89h\nX\x10\x00\x00\x00\x00\x00\x00\x00\x01\
\x00\x00\x00\x02\x00\x00\x00\x02\x00\x00\x00q\x18h\x0c\x86q\x19Rq\x1atq\x1bbX\x07\x00\x00\x00i\
ndicesq\x1ch\x07h\x08K\x00\x85q\x1dh\x0e\x87q\x1eRq\x1f(K\x01K\x02\x85q h\x15\x89h\nX\x08\x00\
\x00\x00\x01\x00\x00\x00\x00\x00\x00\x00q!h\x0c\x86q\"Rq#tq$bX\x04\x00\x00\x00dataq%h\x07h\x08\
K\x00\x85q&h\x0e\x87q'Rq((K\x01K\x02\x85q)h\x12X\x02\x00\x00\x00f8q*\x89\x88\x87q+Rq,(K\x03h\
\x16NNNJ\xff\xff\xff\xffJ\xff\xff\xff\xffK\x00tq-b\x89h\nX\x11\x00\x00\x00\x00\x00\x00\x00\x00\
\x00\x00@\x00\x00\x00\x00\x00\x00\xc3\xb8?q.h\x0c\x86q/Rq0tq1bub.";
/// The same array by columns as a `>f4` in protocol 0 of Python 2.
const PYTHON_2: &[u8] = b"cnumpy.core.multiarray\n_reconstruct\np1\n(cnumpy\nndarray\np2\n(I0\ntp3\nS'b'\np4\
\ntp5\nRp6\n(I1\n(I2\nI2\ntp7\ncnumpy\ndtype\np8\n(S'f4'\np9\nI0\nI1\ntp10\nRp11\n(I3\nS'>'\np12\nNNNI-1\
\nI-1\nI0\ntp13\nbI01\nS'?\\xc0\\x00\\x00@\\x80\\x00\\x00\\xc0\\x00\\x00\\x00@\\xa0\\x00\\x00'\np14\ntp15\nb.";

fn array(bytes: &[u8]) -> Result<Array, ArrayError> {
    let pickle = Pickle::read(bytes, 0).unwrap();
    Array::read(&pickle, pickle.root())
}

#[test]
fn arrays_of_every_protocol_order_and_endianness_read_row_by_row() {
    for bytes in [COLUMNS_0, COLUMNS_2, COLUMNS_5, BIG_ENDIAN] {
        let array = array(bytes).unwrap();
        assert_eq!(array.shape, [2, 3]);
        assert_eq!(array.values, [1.5, -2.0, 3.0, 4.0, 5.0, 200.0]);
    }
    let old = array(PYTHON_2).unwrap();
    assert_eq!((old.shape, old.values), (vec![2, 2], vec![1.5, -2.0, 4.0, 5.0]));
    assert_eq!(array(SCALAR).unwrap().values, [2.5]);
}

#[test]
fn arrays_of_objects_and_other_classes_are_refused_by_name() {
    assert_eq!(array(OBJECTS), Err(ArrayError::Objects));
    let error = array(b"\x80\x02cos\nsystem\nX\x02\x00\x00\x00ls\x85R.").unwrap_err();
    assert_eq!(error.to_string(), "an object of `os.system` instead of a numeric array");
}

#[test]
fn an_array_whose_shape_is_not_its_own_is_refused() {
    // The second length in COLUMNS_2, 3, becomes 255.
    let at = COLUMNS_2.windows(4).position(|w| w == b"K\x02K\x03").unwrap() + 3;
    let mut bytes = COLUMNS_2.to_vec();
    bytes[at] = 255;
    let error = array(&bytes).unwrap_err();
    assert_eq!(error.to_string(), "its shape [2, 255] takes 4080 bytes, 48 are there");
}

#[test]
fn compressed_columns_become_rows_columns_and_values() {
    let pickle = Pickle::read(COMPRESSED, 0).unwrap();
    let sparse = Sparse::read(&pickle, pickle.root()).unwrap().unwrap();
    assert_eq!(sparse.shape, [2, 3]);
    assert_eq!(sparse.entries, [(1, 0, 2.0), (0, 1, 1.5)]);
}

/// `Select(a, idxs, preferred_shape)` of a constant, as Python 2 restores objects in protocol 1.
fn selection(indices: &[u8], shape: &str) -> Vec<u8> {
    let mut bytes = b"(dp1\nS'unused'\np2\n".to_vec();
    bytes.extend(&PYTHON_2[..PYTHON_2.len() - 1]);
    bytes.extend(b"s0ccopy_reg\n_reconstructor\n(cchumpy.reordering\nSelect\nc__builtin__\nobject\nNtR(dS'a'\n");
    bytes.extend(b"ccopy_reg\n_reconstructor\n(cchumpy.ch\nCh\nc__builtin__\nobject\nNtR(dS'x'\ng6\nsbsS'idxs'\n");
    bytes.extend(b"cnumpy.core.multiarray\n_reconstruct\n(g2\n(I0\ntS'b'\ntR(I1\n(I");
    bytes.extend(format!("{}\ntcnumpy\ndtype\n(S'u1'\nI0\nI1\ntRI00\nU", indices.len()).bytes());
    bytes.push(indices.len() as u8);
    bytes.extend(indices);
    bytes.extend(format!("tbsS'preferred_shape'\n({shape}tsb.").bytes());
    bytes
}

#[test]
fn a_selection_of_a_constant_is_the_array_it_stands_for() {
    // Flattened, the constant is [1.5, -2, 4, 5].
    let selected = array(&selection(&[3, 0, 1], "I3\nI1\n")).unwrap();
    assert_eq!((selected.shape, selected.values), (vec![3, 1], vec![5.0, 1.5, -2.0]));
    let beyond = array(&selection(&[3, 4, 1], "I3\n")).unwrap_err();
    assert_eq!(beyond.to_string(), "its description is damaged: an index beyond its array");
    assert!(array(&selection(&[3, 0, 1], "I4\n")).is_err());
}

#[test]
fn a_constant_that_contains_itself_is_refused() {
    let bytes =
        b"ccopy_reg\n_reconstructor\n(cchumpy.ch\nCh\nc__builtin__\nobject\nNtRp1\n(dS'x'\ng1\nsb.";
    let error = array(bytes).unwrap_err();
    assert!(error.to_string().contains("inside of each other"), "{error}");
}

#[test]
fn every_prefix_of_a_pickle_is_refused() {
    let selection = selection(&[3, 0, 1], "I3\n");
    for whole in [COLUMNS_0, COLUMNS_2, COLUMNS_5, PYTHON_2, COMPRESSED, &selection] {
        for end in 0..whole.len() {
            let error = Pickle::read(&whole[..end], 0).unwrap_err();
            assert!(error.byte <= end, "{error}");
        }
    }
}

#[test]
fn a_program_of_nothing_but_values_stops_at_a_limit() {
    let error = Pickle::read(&vec![b'N'; 1 << 22], 0).unwrap_err();
    assert!(error.to_string().contains("more than 2097152 values"), "{error}");
}

#[test]
fn a_text_that_is_named_again_and_again_does_not_fill_the_memory() {
    // One long text; then, in six bytes each, classes whose module and name it is.
    let mut bytes =
        [b"\x80\x04X", &60_000_u32.to_le_bytes()[..], &[b'a'; 60_000], b"\x940"].concat();
    bytes.extend(b"h\0h\0\x930".repeat(10_000));
    let error = Pickle::read(&bytes, 0).unwrap_err();
    assert!(error.to_string().contains("bytes of names of classes"), "{error}");
}

proptest! {
    #[test]
    fn flipped_bytes_never_make_arrays_panic(
        which in 0usize..5,
        flips in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 1..6),
    ) {
        let selection = selection(&[3, 0, 1], "I3\n");
        let mut bytes = [COLUMNS_0, COLUMNS_2, COLUMNS_5, COMPRESSED, &selection][which].to_vec();
        for (at, value) in flips {
            let at = at.index(bytes.len());
            bytes[at] ^= value;
        }
        if let Ok(pickle) = Pickle::read(&bytes, 0) {
            let _ = Array::read(&pickle, pickle.root());
            let _ = Sparse::read(&pickle, pickle.root());
        }
    }
}
