//! The macro behind the registry: Burn's `Module` needs one concrete type, an enum of all networks.

/// Declares `BACKBONES`, and `Backbone` with its dispatch, from lines `file::Network => SPEC, …;`,
/// each of a file beside this one, its type and its [`BackboneSpec`](super::BackboneSpec)s.
macro_rules! backbones {
    ($($file:ident :: $Network:ident => $($SPEC:ident),+;)+) => {
        /// Every backbone, in the order of lists; those of other crates come last.
        pub static BACKBONES: Registry<BackboneEntry> = Registry::new(&[$($(&BackboneEntry {
            name: $file::$SPEC.name,
            about: $file::$SPEC.about,
            smallest_px: $file::$SPEC.smallest_px,
            narrowest: $file::$SPEC.narrowest,
            build: Build::BuiltIn(|width, outputs, device| {
                Backbone::$Network(($file::$SPEC.build)(width, outputs, device))
            }),
        },)+)+]);

        /// A network of any registered kind.
        #[derive(Module, Debug)]
        #[allow(clippy::large_enum_variant, reason = "one per network, never in a collection")]
        pub(crate) enum Backbone {
            $($Network($file::$Network),)+
            External(ExternalNet),
        }

        impl BackboneNet for Backbone {
            fn forward<N: NetOps>(&self, images: N) -> N::Vector {
                match self {
                    $(Self::$Network(network) => network.forward(images),)+
                    Self::External(network) => network.forward(images),
                }
            }

            fn initializer(&self, slot: &Slot) -> Initializer {
                match self {
                    $(Self::$Network(network) => network.initializer(slot),)+
                    Self::External(network) => BackboneNet::initializer(network, slot),
                }
            }

            fn torchvision_path(&self, path: &str) -> String {
                match self {
                    $(Self::$Network(network) => network.torchvision_path(path),)+
                    Self::External(network) => network.torchvision_path(path),
                }
            }
        }
    };
}

pub(super) use backbones;
