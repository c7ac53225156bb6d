//! Our own weight files: Burn's container (`.bpk`) with a [`ModelCard`] in its metadata and its SHA-256 at its end.
//!
//! The same weights give the same bytes: tensors are in the order of the network's fields and
//! carry no ids.

use std::path::Path;

use burn::module::Module;
use burn::tensor::{Bytes, DType, Device, TensorData};
use burn_store::burn_pack::{Reader, Tensor as PackTensor, Writer};
use evpose_core::atomic_write;
use serde::Serialize;
use serde::de::DeserializeOwned;

use super::digest::{read_checked, with_digest};
use super::mapped::map;
use super::strict::{Layout, Stored, TensorError, fill_strictly};
use super::{BaselineCard, BodyCard, ModelCard};
use crate::parameters::read;
use crate::{BaselineNetwork, HandRegressor, MoveEnet, NnError};

const FORMAT: &str = "burnpack";
/// The beginning of the keys of cards among the container's metadata; the name of the task follows.
const KEYS: &str = "evpose.";
/// The key of hands: their files are older than the names of tasks.
const HAND_KEY: &str = "evpose.model";

/// A network that weight files hold, with a card that describes it.
pub trait StoredNetwork: Module {
    /// The description, kept inside the file as TOML.
    type Card: Clone + Serialize + DeserializeOwned;

    /// Key of the card: `evpose.` and the name of the task.
    const KEY: &'static str;

    /// The card with the configuration that the network was built from.
    fn described(&self, card: &Self::Card) -> Self::Card {
        card.clone()
    }

    /// A network of the described shape, whose weights are yet to be filled.
    ///
    /// # Errors
    /// If there is none.
    fn of_card(card: &Self::Card, device: &Device) -> Result<Self, NnError>;
}

impl StoredNetwork for HandRegressor {
    type Card = ModelCard;

    const KEY: &'static str = HAND_KEY;

    fn described(&self, card: &ModelCard) -> ModelCard {
        ModelCard { network: self.config().clone(), ..card.clone() }
    }

    fn of_card(card: &ModelCard, device: &Device) -> Result<Self, NnError> {
        card.network.zeros(device)
    }
}

impl StoredNetwork for MoveEnet {
    type Card = BodyCard;

    const KEY: &'static str = "evpose.body";

    fn described(&self, card: &BodyCard) -> BodyCard {
        BodyCard { network: self.config().clone(), ..card.clone() }
    }

    fn of_card(card: &BodyCard, device: &Device) -> Result<Self, NnError> {
        card.network.zeros(device)
    }
}

impl StoredNetwork for BaselineNetwork {
    type Card = BaselineCard;

    const KEY: &'static str = "evpose.baseline";

    fn described(&self, card: &BaselineCard) -> BaselineCard {
        BaselineCard { network: self.config(), ..card.clone() }
    }

    fn of_card(card: &BaselineCard, device: &Device) -> Result<Self, NnError> {
        card.network.zeros(device)
    }
}

/// Writes `network` to `path`, whole or not at all. What the card says of the network is replaced by its
/// own configuration.
///
/// # Errors
/// [`NnError::Io`] if the file cannot be written.
pub fn save<N: StoredNetwork>(path: &Path, network: &N, card: &N::Card) -> Result<(), NnError> {
    let card = toml::to_string(&network.described(card))
        .map_err(|error| NnError::Card { path: path.to_owned(), reason: error.to_string() })?;
    let tensors = read(network).into_iter().map(|(slot, values)| {
        let bytes = values.iter().flat_map(|value| value.to_le_bytes()).collect();
        PackTensor::new(slot.path, DType::F32, slot.shape, None, Bytes::from_bytes_vec(bytes))
    });
    let bytes = Writer::new(tensors.collect())
        .with_metadata(N::KEY, &card)
        .into_bytes()
        .map_err(|error| unreadable(path, &error))?;
    // Whole or not at all: a crash leaves the file before in its place.
    atomic_write(path, &with_digest(&bytes))
        .map_err(|source| NnError::Io { path: path.to_owned(), source })
}

/// Reads a network and its card from `path`.
///
/// # Errors
/// [`NnError::Io`], [`NnError::Damaged`] if its digest is another, [`NnError::Unreadable`] if it is no container,
/// [`NnError::Card`] for a container without a card, [`NnError::Mismatch`] for weights of another network than the card says.
pub fn load<N: StoredNetwork>(path: &Path, device: &Device) -> Result<(N, N::Card), NnError> {
    let unreadable = |error| unreadable(path, &error);
    let reader = Reader::from_bytes(read_checked(path)?).map_err(unreadable)?;
    let without_card = |reason: String| NnError::Card { path: path.to_owned(), reason };
    // The card comes first: it says which network the tensors have to fit.
    let card = reader.metadata().get(N::KEY);
    let card = card.ok_or_else(|| without_card(format!("no `{}` entry", N::KEY)))?;
    let card: N::Card = toml::from_str(card).map_err(|error| without_card(error.to_string()))?;
    let network = N::of_card(&card, device)?;
    let tensors = reader.into_tensors().map_err(unreadable)?;
    let file = tensors.into_iter().map(|tensor| (tensor.name.clone(), stored(tensor))).collect();
    Ok((fill_strictly(network, &Native, file, path, FORMAT)?, card))
}

/// The task of a weight file, `hand`, `body`, `baseline` or that of another crate, by the key of its
/// card, which may be damaged; none if it is no file of ours.
pub fn task_of(path: &Path) -> Option<String> {
    let reader = Reader::from_bytes(map(path).ok()?).ok()?;
    let key = reader.metadata().keys().find(|key| key.starts_with(KEYS))?;
    let task = if *key == HAND_KEY { "hand" } else { &key[KEYS.len()..] };
    Some(task.to_owned())
}

/// Names, shapes and order as in memory.
struct Native;

impl Layout for Native {}

fn stored(tensor: PackTensor) -> Stored {
    let shape = tensor.shape.to_vec();
    // A file of another network is refused before any of its values is copied.
    let read = move || {
        let (_, dtype, shape, _, bytes) = tensor.into_parts().map_err(TensorError::of)?;
        if dtype != DType::F32 {
            return Err(TensorError::of(format!("{dtype:?} values where F32 are written")));
        }
        Ok(TensorData::from_bytes(bytes, shape, dtype))
    };
    Stored { shape, read: Box::new(read) }
}

fn unreadable(path: &Path, reason: &impl ToString) -> NnError {
    NnError::Unreadable { path: path.to_owned(), format: FORMAT, reason: reason.to_string() }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::weights::InputConfig;
    use crate::{HandRegressorConfig, MoveEnetConfig};
    use burn::tensor::Tensor;

    fn network(seed: u64, device: &Device) -> HandRegressor {
        let config = HandRegressorConfig {
            backbone: "resnet18".into(),
            width: 0.0625,
            ..HandRegressorConfig::default()
        };
        config.init(seed, device).unwrap()
    }

    fn images(device: &Device) -> Tensor<4> {
        let values: Vec<f32> = (0..2 * 2 * 24 * 32).map(|i| (i % 7) as f32 / 7.0).collect();
        Tensor::from_data(TensorData::new(values, [2, 2, 24, 32]), device)
    }

    fn outputs(network: &HandRegressor) -> Vec<f32> {
        network.forward(images(&Device::flex())).into_data().iter().collect()
    }

    #[test]
    fn a_body_comes_back_and_is_no_hand() {
        let (folder, device) = (tempfile::tempdir().unwrap(), Device::flex());
        let path = folder.path().join("body.bpk");
        let config = MoveEnetConfig { joints: 3, width: 0.25, expansion: 2 };
        let saved = config.init(7, &device).unwrap();
        let provenance = [("seed".to_owned(), "5".to_owned())].into();
        save(&path, &saved, &BodyCard { provenance, ..BodyCard::default() }).unwrap();
        let (back, card) = load::<MoveEnet>(&path, &device).unwrap();
        assert_eq!((&card.network, card.provenance["seed"].as_str()), (&config, "5"));
        assert_eq!((read(&back), back.config()), (read(&saved), &config));
        assert!(matches!(load::<HandRegressor>(&path, &device), Err(NnError::Card { .. })));
        assert_eq!((task_of(&path).as_deref(), task_of(folder.path())), (Some("body"), None));
        save(&path, &network(5, &device), &ModelCard::default()).unwrap();
        assert_eq!(task_of(&path).as_deref(), Some("hand"));
    }

    #[test]
    fn a_baseline_comes_back_whichever_it_is() {
        use crate::{BaselineNetworkConfig, Dhp19CnnConfig, LiftMonoConfig};
        let (folder, device) = (tempfile::tempdir().unwrap(), Device::flex());
        let path = folder.path().join("baseline.bpk");
        let lift = LiftMonoConfig { joints: 2, width: 0.0625, stages: 2 };
        for config in [
            BaselineNetworkConfig::Dhp19Cnn(Dhp19CnnConfig { joints: 3, width: 0.125 }),
            BaselineNetworkConfig::LiftMono(lift),
        ] {
            let saved = config.init(7, &device).unwrap();
            save(&path, &saved, &BaselineCard::default()).unwrap();
            let (back, card) = load::<BaselineNetwork>(&path, &device).unwrap();
            assert_eq!((&card.network, back.config()), (&config, config.clone()));
            assert_eq!(read(&back), read(&saved));
            assert!(matches!(load::<MoveEnet>(&path, &device), Err(NnError::Card { .. })));
        }
    }

    #[test]
    fn a_checkpoint_describes_itself_and_gives_the_same_outputs() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("hand.bpk");
        let input = InputConfig { width_px: 32, height_px: 24, ..InputConfig::default() };
        let provenance = [("seed".to_owned(), "5".to_owned())].into();
        let saved = network(5, &Device::flex());
        let card = ModelCard { input, provenance, ..ModelCard::default() };
        save(&path, &saved, &card).unwrap();
        let (loaded, read) = load(&path, &Device::flex()).unwrap();
        assert_eq!(read, ModelCard { network: saved.config().clone(), ..card });
        assert_eq!(outputs(&loaded), outputs(&saved));
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1);
    }

    #[test]
    fn the_same_weights_give_the_same_bytes() {
        let folder = tempfile::tempdir().unwrap();
        let bytes = |name: &str| {
            let path = folder.path().join(name);
            save(&path, &network(5, &Device::flex()), &ModelCard::default()).unwrap();
            std::fs::read(path).unwrap()
        };
        assert!(bytes("a.bpk") == bytes("b.bpk"));
    }

    #[test]
    fn the_last_training_step_is_in_the_saved_statistics() {
        use burn::module::Module;
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("hand.bpk");
        let device = Device::flex().autodiff();
        let trained = network(5, &device);
        let before = outputs(&trained.valid());
        trained.forward(images(&device));
        save(&path, &trained, &ModelCard::default()).unwrap();
        let (loaded, _) = load(&path, &Device::flex()).unwrap();
        assert!(outputs(&loaded) != before);
        assert_eq!(outputs(&loaded), outputs(&trained.valid()));
    }

    #[test]
    fn no_cut_of_a_checkpoint_loads_or_panics() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("hand.bpk");
        save(&path, &network(5, &Device::flex()), &ModelCard::default()).unwrap();
        let whole = std::fs::read(&path).unwrap();
        let step = whole.len() / 40;
        for length in (0..whole.len()).step_by(step).chain([whole.len() - 1]) {
            std::fs::write(&path, &whole[..length]).unwrap();
            let error = load::<HandRegressor>(&path, &Device::flex()).map(|_| ()).unwrap_err();
            assert!(matches!(error, NnError::Damaged { .. }), "{length}: {error}");
        }
    }

    #[test]
    fn weights_of_another_network_than_the_card_says_are_named() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("hand.bpk");
        let tensor = |name: &str, count: usize| {
            let bytes = Bytes::from_bytes_vec(vec![0; 4 * count]);
            PackTensor::new(name.into(), DType::F32, vec![count], None, bytes)
        };
        let card = ModelCard {
            network: network(1, &Device::flex()).config().clone(),
            ..ModelCard::default()
        };
        let tensors = vec![tensor("conv1.bias", 4), tensor("strange", 1)];
        let writer = Writer::new(tensors).with_metadata(HAND_KEY, &toml::to_string(&card).unwrap());
        std::fs::write(&path, with_digest(&writer.into_bytes().unwrap())).unwrap();
        let error = load::<HandRegressor>(&path, &Device::flex()).map(|_| ()).unwrap_err();
        let NnError::Mismatch { mismatch, .. } = &error else { panic!("{error}") };
        assert_eq!(mismatch.unexpected, ["strange"]);
        assert_eq!(mismatch.reshaped, [("conv1.bias".into(), vec![3], vec![4])]);
        assert!(mismatch.missing.contains(&"conv1.weight".to_owned()));
    }
}
