//! Reads and runs ONNX networks with the crate `tract`. Compiled with the feature `networks` only; `super` calls it.

use std::cell::Cell;
use std::collections::BTreeMap;
use std::panic::{self, AssertUnwindSafe};
use std::sync::{Arc, Mutex, Once, PoisonError};

use tract_onnx::prelude::*;

use super::NetworkError;

/// The metadata in which a file may state the smallest side of a picture, in pixels. For smaller pictures the runtime
/// gives numbers too, but not those that the training framework would give.
const SMALLEST_SIDE: &str = "onnx.metadata_props.smallest_side";

/// A network as it was read, and the same network made ready for each size of picture that was asked for.
pub struct Model {
    any_size: InferenceModel,
    smallest_side: usize,
    ready: Mutex<BTreeMap<(usize, usize), Arc<TypedSimplePlan>>>,
}

impl Model {
    /// # Errors
    /// What is wrong with the file.
    pub fn parse(onnx: &[u8]) -> Result<Model, NetworkError> {
        without_panic(|| Model::parsed(onnx))
    }

    fn parsed(onnx: &[u8]) -> Result<Model, NetworkError> {
        let any_size = tract_onnx::onnx().model_for_read(&mut &*onnx).map_err(unusable)?;
        let count = |what: &str, found: usize, wanted: usize| match found == wanted {
            true => Ok(()),
            false => Err(NetworkError::Unusable(format!("it has {found} {what} instead of {wanted}"))),
        };
        count("inputs", any_size.inputs.len(), 2)?;
        count("outputs", any_size.outputs.len(), 1)?;
        let smallest_side = match any_size.properties.get(SMALLEST_SIDE) {
            None => 1,
            Some(stated) => {
                let text =
                    stated.try_as_plain_ram().and_then(|s| s.to_scalar::<String>().cloned()).map_err(unusable)?;
                let no_side =
                    || NetworkError::Unusable(format!("its smallest_side `{}` is not a count", text.escape_debug()));
                text.parse().ok().filter(|side| *side > 0).ok_or_else(no_side)?
            }
        };
        Ok(Model { any_size, smallest_side, ready: Mutex::default() })
    }

    /// See [`super::Network::distance`].
    ///
    /// # Errors
    /// The pictures are too small, or the network cannot compare them.
    pub fn distance(&self, size: (usize, usize), pictures: [&[[f32; 3]]; 2]) -> Result<Option<f64>, NetworkError> {
        without_panic(|| self.measured(size, pictures))
    }

    fn measured(&self, size: (usize, usize), pictures: [&[[f32; 3]]; 2]) -> Result<Option<f64>, NetworkError> {
        let plan = self.plan(size)?;
        let inputs = pictures.map(|picture| tensor(size, picture).map(TValue::from));
        let inputs = inputs.into_iter().collect::<TractResult<TVec<TValue>>>().map_err(unusable)?;
        let outputs = plan.run(inputs).map_err(unusable)?;
        let distance = outputs[0].try_as_plain_ram().ok().and_then(|plain| match plain.as_slice::<f32>() {
            Ok([distance]) => Some(f64::from(*distance)),
            _ => None,
        });
        let no_number = || NetworkError::Unusable("its output is not a single number".to_owned());
        distance.map(|d| d.is_finite().then_some(d)).ok_or_else(no_number)
    }

    fn plan(&self, (width, height): (usize, usize)) -> Result<Arc<TypedSimplePlan>, NetworkError> {
        let least = self.smallest_side;
        if width.min(height) < least {
            return Err(NetworkError::TooSmall { least, width, height });
        }
        // A poisoned lock does no harm, because a plan is added only when it is complete.
        let mut ready = self.ready.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(plan) = ready.get(&(width, height)) {
            return Ok(Arc::clone(plan));
        }
        let fact = || InferenceFact::dt_shape(f32::datum_type(), [1, 3, height, width]);
        let plan = self.any_size.clone().with_input_fact(0, fact());
        let plan = plan.and_then(|model| model.with_input_fact(1, fact()));
        let plan = plan.and_then(|model| model.into_optimized()?.into_runnable()).map_err(unusable)?;
        ready.insert((width, height), Arc::clone(&plan));
        Ok(plan)
    }
}

/// The picture as the training frameworks lay it out, channel by channel: 1×3×height×width.
fn tensor((width, height): (usize, usize), picture: &[[f32; 3]]) -> TractResult<Tensor> {
    let planes: Vec<f32> = (0..3).flat_map(|channel| picture.iter().map(move |texel| texel[channel])).collect();
    Tensor::from_shape(&[1, 3, height, width], &planes)
}

/// The error with its reasons, from the outermost to the innermost.
fn unusable(error: TractError) -> NetworkError {
    let reasons: Vec<String> =
        error.chain().map(|reason| reason.to_string().trim_end_matches('.').to_owned()).collect();
    NetworkError::Unusable(reasons.join(": ").escape_debug().to_string())
}

/// Does some work of the runtime and turns a panic into an error. The runtime panics at some damaged files. Nothing of
/// such a panic is printed.
fn without_panic<T>(work: impl FnOnce() -> Result<T, NetworkError>) -> Result<T, NetworkError> {
    thread_local! { static IS_QUIET: Cell<bool> = const { Cell::new(false) }; }
    static HOOK: Once = Once::new();
    HOOK.call_once(|| {
        let others = panic::take_hook();
        panic::set_hook(Box::new(move |info| {
            if !IS_QUIET.get() {
                others(info);
            }
        }));
    });
    IS_QUIET.set(true);
    // Unwinding is safe: the work only reads what it borrows, except for the plans, which are added when they are
    // complete.
    let result = panic::catch_unwind(AssertUnwindSafe(work));
    IS_QUIET.set(false);
    result.unwrap_or_else(|panic| {
        let text = panic.downcast_ref::<&str>().map(|s| (*s).to_owned());
        let text = text.or_else(|| panic.downcast_ref::<String>().cloned()).unwrap_or_default();
        Err(NetworkError::Unusable(format!("the runtime cannot read it ({})", text.escape_debug())))
    })
}
