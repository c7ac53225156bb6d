//! Files of hand models, as a user meets them.

use crate::harness::Sandbox;

const VERTICES: usize = 778;
const JOINTS: usize = 16;

/// A right hand in the published shapes, as Python 2 pickles it: small numbers, no real hand.
fn hand() -> Vec<u8> {
    let floats = |values: &mut dyn Iterator<Item = f32>| -> Vec<u8> {
        values.flat_map(f32::to_le_bytes).collect()
    };
    let template = floats(&mut (0..3 * VERTICES).map(|k| 0.01 * (k / 3 % 19) as f32));
    // The tree of the published model: chains of three joints behind the wrist.
    let tree = floats(&mut (0..2 * JOINTS).map(|k| match (k, k % JOINTS) {
        (0, _) => -1.0,
        (_, joint) if k >= JOINTS => joint as f32,
        (_, joint) if joint % 3 == 1 => 0.0,
        (_, joint) => joint as f32 - 1.0,
    }));
    let weights: Vec<u8> = (0..VERTICES * JOINTS).map(|k| u8::from(k % JOINTS == 0)).collect();
    let regressor: Vec<u8> = (0..VERTICES * JOINTS).map(|k| u8::from(k % VERTICES == 0)).collect();
    // Protocol 2, as Python 2 wrote it.
    let mut out = b"\x80\x02}(".to_vec();
    array(&mut out, "v_template", &[VERTICES, 3], "f4", &template);
    array(&mut out, "shapedirs", &[VERTICES, 3, 10], "u1", &[0; VERTICES * 30]);
    array(&mut out, "weights", &[VERTICES, JOINTS], "u1", &weights);
    array(&mut out, "J_regressor", &[JOINTS, VERTICES], "u1", &regressor);
    array(&mut out, "kintree_table", &[2, JOINTS], "f4", &tree);
    array(&mut out, "f", &[2, 3], "u1", &[0, 1, 2, 0, 2, 3]);
    array(&mut out, "hands_components", &[45, 45], "u1", &[0; 2025]);
    array(&mut out, "hands_mean", &[45], "u1", &[0; 45]);
    out.extend(b"u.");
    out
}

fn array(out: &mut Vec<u8>, name: &str, shape: &[usize], kind: &str, content: &[u8]) {
    let text = |out: &mut Vec<u8>, text: &str| {
        out.extend([b'U', text.len() as u8]);
        out.extend(text.bytes());
    };
    text(out, name);
    // Opcodes of a pickled array: the function that rebuilds it, and its arguments.
    out.extend(b"cnumpy.core.multiarray\n_reconstruct\ncnumpy\nndarray\nK\0\x85U\x01b\x87R(K\x01(");
    for &length in shape {
        out.push(b'J');
        out.extend((length as u32).to_le_bytes());
    }
    out.extend(b"tcnumpy\ndtype\n");
    text(out, kind);
    out.extend(b"K\0K\x01\x87R(K\x03U\x01<NNNJ\xff\xff\xff\xffJ\xff\xff\xff\xffK\0tb\x89T");
    out.extend((content.len() as u32).to_le_bytes());
    out.extend(content);
    out.extend(b"tb");
}

#[test]
fn info_describes_a_model_of_a_hand_and_says_where_a_cut_one_ends() {
    let sandbox = Sandbox::new();
    sandbox.write("hand.pkl", hand());
    insta::assert_snapshot!("info_hand", sandbox.ok(&["info", "hand.pkl"]));
    sandbox.write("cut.pkl", &hand()[..20_000]);
    let message = sandbox.fails(&["info", "cut.pkl"]);
    assert!(message.contains("cut.pkl") && message.contains("20000 bytes"), "{message}");
    assert!(message.contains("pickle, byte"), "{message}");
}
