//! The types of `cubecl-llvm` that `cubecl-cuda` 0.11.3 names, without LLVM.
//!
//! With the feature `cpp` of `cubecl-cuda`, kernels are translated to CUDA C++ and compiled by NVRTC
//! when the program runs; of `cubecl-llvm` only types are left. This crate has them, so that a build
//! needs no archive of LLVM. Whoever compiles a kernel by it gets an error that says so.

/// The machine code of NVIDIA's GPUs, which is never made here.
#[derive(Debug, Clone)]
pub struct NvptxModule {
    /// Assembly with a zero at the end.
    pub ptx: Vec<core::ffi::c_char>,
    /// The kernel's symbol.
    pub entrypoint: String,
    /// Intermediate code.
    pub ir: String,
    /// Bytes of shared memory.
    pub shared_memory_size: usize,
    /// Access of the kernel to each buffer.
    pub io: Vec<cubecl_server::kernel::BufferIOAttr>,
}

/// The compiler's target.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum LlvmTarget {
    /// The CPU.
    #[default]
    Cpu,
    /// NVIDIA's GPUs.
    Nvptx,
}

/// The compiler that is not here.
#[derive(Clone, Debug, Default)]
pub struct PlironCompiler {
    /// The target.
    pub target: LlvmTarget,
}

/// Its options.
#[derive(Clone, Debug, Default)]
pub struct PlironOptions {
    /// Always none: an architecture of AMD.
    pub arch: Option<core::convert::Infallible>,
    /// The architecture.
    pub sm_arch: Option<cubecl_core::ir::nvidia::SmArch>,
    /// The version of the assembly.
    pub ptx_version: Option<nvptx::ptx_version::PtxVersion>,
    /// Whether scalars are parameters of the kernel.
    pub grid_constants: bool,
}

/// A compiled kernel.
#[derive(Clone)]
pub enum PlironArtifact {
    /// For the CPU.
    Jit(core::convert::Infallible),
    /// For NVIDIA's GPUs.
    NvptxCode(NvptxModule),
}

impl core::fmt::Display for PlironArtifact {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self {
            Self::Jit(never) => match *never {},
            Self::NvptxCode(module) => f.write_str(&module.ir),
        }
    }
}

impl cubecl_server::compiler::Compiler for PlironCompiler {
    type Representation = PlironArtifact;
    type CompilationOptions = PlironOptions;

    fn compile(
        &mut self,
        _: cubecl_core::prelude::KernelDefinition,
        _: &PlironOptions,
    ) -> Result<PlironArtifact, cubecl_server::compiler::CompilationError> {
        Err(cubecl_server::compiler::CompilationError::UnsupportedInstruction {
            reason: "built without LLVM: enable the feature `cpp` of cubecl-cuda".to_owned(),
            backtrace: cubecl_environment::backtrace::BackTrace::capture(),
        })
    }

    fn extension(&self) -> &'static str {
        "ll"
    }

    fn lang_tag(&self) -> &'static str {
        "llvm"
    }
}

/// NVIDIA's GPUs.
pub mod nvptx {
    /// Versions of the assembly language.
    pub mod ptx_version {
        /// A version: 8.7 is 87.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
        pub struct PtxVersion(u32);

        impl PtxVersion {
            /// None is chosen: NVRTC writes its own.
            pub fn for_driver(_: i32) -> Option<Self> {
                None
            }
        }

        impl core::fmt::Display for PtxVersion {
            fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
                write!(f, "ptx{}", self.0)
            }
        }
    }
}

/// Types of all targets.
pub mod shared {
    /// Capabilities of a device.
    pub mod lowered_features {
        /// The target.
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        pub enum GpuTarget {
            /// NVIDIA's GPUs.
            Nvptx,
        }

        /// Nothing is taken away: the C++ compiler has it all.
        pub fn restrict_features(_: &mut cubecl_core::ir::DeviceProperties, _: GpuTarget) {}
    }
}
