//! The instructions of [`Amx`] against the emulated unit. On a processor that does not know them, the
//! system's signal for an invalid instruction leads to a decoder, which has the emulation do what the
//! instruction says: so the assembly itself is tested, its opcodes, order of operands and addresses.

use std::cell::RefCell;
use std::mem::zeroed;
use std::ptr::{from_ref, null_mut};
use std::sync::Once;

use super::*;
use crate::level::Level;

thread_local! {
    /// The tiles of a thread, if it has configured them.
    static TILES: RefCell<Option<EmulatedTiles>> = const { RefCell::new(None) };
}

/// Registers of the context of a signal, in the order of their codes in instructions.
const REGISTERS: [libc::c_int; 16] = [
    libc::REG_RAX,
    libc::REG_RCX,
    libc::REG_RDX,
    libc::REG_RBX,
    libc::REG_RSP,
    libc::REG_RBP,
    libc::REG_RSI,
    libc::REG_RDI,
    libc::REG_R8,
    libc::REG_R9,
    libc::REG_R10,
    libc::REG_R11,
    libc::REG_R12,
    libc::REG_R13,
    libc::REG_R14,
    libc::REG_R15,
];

/// Numbered registers of the interrupted thread.
type Registers = [libc::greg_t; 23];

/// An instruction with a three-byte VEX prefix, and no operands but registers and one address.
struct Instruction {
    /// Opcode and mandatory prefix (none, 66, F3 or F2 as 0 to 3), as the manual lists them.
    opcode: [u8; 2],
    /// Register of `ModRM.reg`, and of `VEX.vvvv`.
    reg: usize,
    vvvv: usize,
    operand: Operand,
    bytes: usize,
}

/// `ModRM.rm`.
enum Operand {
    Register(usize),
    Memory { base: usize, index: usize },
}

/// Decodes the instruction at `code`; none if it is not of this kind.
///
/// # Safety
/// An instruction is there.
unsafe fn decode(code: *const u8, registers: &Registers) -> Option<Instruction> {
    // SAFETY: bytes of one instruction; later ones are read as earlier ones say that they exist.
    let byte = |at: usize| unsafe { *code.add(at) };
    let value = |register: u8| registers[REGISTERS[usize::from(register)] as usize] as usize;
    if byte(0) != 0xC4 || byte(1) & 0x1F != 2 {
        return None;
    }
    // These bits are stored inverted: they extend the codes of reg, index and base to 16.
    let [r, x, b] = [7, 6, 5].map(|bit| (!byte(1) >> bit & 1) << 3);
    let (vvvv, prefix) = (usize::from(!byte(2) >> 3 & 15), byte(2) & 3);
    let (modrm, mut bytes) = (byte(4), 5);
    let (mode, rm) = (modrm >> 6, modrm & 7);
    let operand = if mode == 3 {
        Operand::Register(rm.into())
    } else {
        let mut base = rm | b;
        let mut index = 0;
        if rm == 4 {
            let sib = byte(5);
            bytes += 1;
            base = sib & 7 | b;
            let index_register = sib >> 3 & 7 | x;
            if index_register != 4 {
                index = value(index_register) << (sib >> 6);
            }
        }
        // Addresses without a base are those of other code.
        if mode == 0 && base & 7 == 5 {
            return None;
        }
        let displacement = match mode {
            0 => 0,
            1 => isize::from(byte(bytes) as i8),
            _ => i32::from_le_bytes([0, 1, 2, 3].map(|at| byte(bytes + at))) as isize,
        };
        bytes += [0, 1, 4][usize::from(mode)];
        Operand::Memory { base: value(base).wrapping_add_signed(displacement), index }
    };
    let reg = (modrm >> 3 & 7 | r).into();
    Some(Instruction { opcode: [byte(3), prefix], reg, vvvv, operand, bytes })
}

/// Has the emulation do an instruction; none if it is not one of AMX.
///
/// # Safety
/// Memory that the instruction names is readable or writable.
unsafe fn execute(instruction: &Instruction, tiles: &mut Option<EmulatedTiles>) -> Option<()> {
    let Instruction { opcode, reg, vvvv, operand, .. } = instruction;
    // SAFETY: the caller's.
    unsafe {
        match (opcode, operand) {
            ([0x49, 0], Operand::Memory { base, .. }) => {
                *tiles = Some(EmulatedTiles::configure(&*(*base as *const TileConfig)));
            }
            ([0x49, 0], Operand::Register(_)) => *tiles = None,
            ([0x49, 3], Operand::Register(_)) => tiles.as_mut()?.zero_tile(*reg),
            ([0x4B, 3], Operand::Memory { base, index }) => {
                tiles.as_mut()?.load_tile(*reg, *base as *const u8, *index);
            }
            ([0x4B, 2], Operand::Memory { base, index }) => {
                tiles.as_mut()?.store_tile(*reg, *base as *mut u8, *index);
            }
            ([0x5E, 1], Operand::Register(a)) => tiles.as_mut()?.add_u8([*reg, *a, *vvvv]),
            ([0x5C, 2], Operand::Register(a)) => tiles.as_mut()?.add_bf16([*reg, *a, *vvvv]),
            _ => return None,
        }
    }
    Some(())
}

/// Handler of the signal.
extern "C" fn on_invalid_instruction(
    _: libc::c_int,
    _: *mut libc::siginfo_t,
    context: *mut libc::c_void,
) {
    // SAFETY: the system passes the context of the thread that met the instruction.
    let registers = unsafe { &mut (*context.cast::<libc::ucontext_t>()).uc_mcontext.gregs };
    let rip = libc::REG_RIP as usize;
    // SAFETY: the instruction that was met; its memory is what `Amx` was given.
    let done = unsafe {
        decode(registers[rip] as *const u8, registers).and_then(|instruction| {
            TILES.with_borrow_mut(|tiles| execute(&instruction, tiles))?;
            Some(instruction.bytes)
        })
    };
    match done {
        Some(bytes) => registers[rip] += bytes as libc::greg_t,
        // SAFETY: the instruction is met again, and ends the program.
        None => unsafe {
            libc::signal(libc::SIGILL, libc::SIG_DFL);
        },
    }
}

/// Compares the instructions of AMX with the emulation.
fn compare_bytes() {
    let sums = [-7; TILE_BYTES / 4];
    for (seed, size) in (0..).zip(SIZES) {
        let (a, b) = (random_bytes(seed), random_bytes(seed + 100));
        let expected = products::<u8, EmulatedTiles>(size, &sums, &a, &b);
        assert_eq!(products::<u8, Amx>(size, &sums, &a, &b), expected, "{size:?}");
    }
}

/// [`compare_bytes`] for bfloat16.
fn compare_bf16() {
    let sums = [0.25; TILE_BYTES / 4];
    for (seed, size) in (0..).zip(SIZES) {
        let (a, b) = (random_bf16(seed), random_bf16(seed + 100));
        let expected = products::<Bf16, EmulatedTiles>(size, &sums, &a, &b);
        assert_eq!(products::<Bf16, Amx>(size, &sums, &a, &b), expected, "{size:?}");
    }
}

/// Sets a loaded tile to zero.
fn zero_a_tile() {
    let mut stored = [1_u8; 12];
    // SAFETY: the caller's processor has the unit; a row of 12 bytes.
    unsafe {
        let mut unit = Amx::configure(&config([1, 3, 1]));
        unit.load::<A>(stored.as_ptr(), 12);
        unit.zero::<A>();
        unit.store::<A>(stored.as_mut_ptr(), 12);
        unit.release();
    }
    assert_eq!(stored, [0; 12]);
}

/// Runs `test` on the processor where it has AMX for elements of type `S`, else with invalid
/// instructions trapped.
fn on_amx<S: TileElement>(test: fn()) {
    if S::has_amx(Level::best()) {
        return test();
    }
    static INSTALLED: Once = Once::new();
    INSTALLED.call_once(|| {
        // SAFETY: an action of this signature, for a signal that nobody else here handles.
        unsafe {
            let mut action: libc::sigaction = zeroed();
            action.sa_sigaction = on_invalid_instruction as *const () as usize;
            action.sa_flags = libc::SA_SIGINFO;
            assert_eq!(
                libc::sigaction(libc::SIGILL, from_ref(&action), null_mut()),
                0,
                "installed"
            );
        }
    });
    test();
    TILES.with_borrow(|tiles| assert!(tiles.is_none(), "released"));
}

#[test]
fn instructions_for_bytes_mean_what_the_emulation_does() {
    on_amx::<u8>(compare_bytes);
}

#[test]
fn instructions_for_bfloat16_mean_what_the_emulation_does() {
    on_amx::<Bf16>(compare_bf16);
}

#[test]
fn the_instruction_that_zeroes_a_tile_zeroes_it() {
    on_amx::<u8>(zero_a_tile);
}
