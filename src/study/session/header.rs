//! Writes the records that a journal holds before trial 1.

use cyclopean_analysis::journal::FORMAT;
use cyclopean_analysis::journal::record;

use super::Options;
use crate::display::DisplayInfo;
use crate::study::poses;
use crate::study::sessions::SessionPlace;
use crate::study::store::StoredStimulus;
use crate::study::validate::Study;

/// The program, as journals name it.
pub fn program() -> record::Program {
    record::Program {
        name: env!("CARGO_PKG_NAME").to_owned(),
        version: env!("CARGO_PKG_VERSION").to_owned(),
        commit: option_env!("CYCLOPEAN_COMMIT").unwrap_or("unknown").to_owned(),
    }
}

pub(super) fn stimulus_record(id: u32, stored: &StoredStimulus) -> record::Stimulus {
    let side_car = &stored.side_car;
    record::Stimulus {
        id,
        key: side_car.key.clone(),
        scene: side_car.request.scene.clone(),
        view: side_car.request.view.clone().unwrap_or_else(|| "default".to_owned()),
        method: side_car.request.method.clone(),
        files: side_car.files.clone(),
        scene_sha256: side_car.info.scene_sha256.clone(),
        shaders_sha256: side_car.info.shaders_sha256.clone(),
        renderer: Some(side_car.info.renderer.clone()),
        film: side_car.info.film,
    }
}

pub(super) fn header(study: &Study, place: &SessionPlace, display: &DisplayInfo, options: &Options) -> record::Header {
    let d = &study.definition;
    record::Header {
        format: FORMAT,
        study: record::Study {
            id: d.id.clone(),
            title: d.title.clone(),
            sha256: study.sha256.clone(),
            text: study.text.clone(),
            seed: d.seed,
        },
        participant: place.participant.clone(),
        session: place.session.clone(),
        row: place.row,
        question: d.journal_question(),
        analysis: d.analysis.clone(),
        program: program(),
        display: record::Display {
            kind: display.kind.clone(),
            system: display.system.clone(),
            runtime: display.runtime.clone(),
            trust: display.trust,
            nominal_hz: display.nominal_hz,
            measured_hz: display.measured_hz,
            interval_sd_ms: display.interval_sd_ms,
            width_px: display.width_px,
            height_px: display.height_px,
            fov_deg: display.fov_deg,
            ipd_m: display.ipd_m,
            rendered_ipd_m: d.stimuli.ipd_m,
        },
        device: display.device.clone(),
        os: format!("{} {}", std::env::consts::OS, std::env::consts::ARCH),
        consent: d.consent.as_ref().map(|c| record::Consent {
            version: c.version.clone(),
            purpose: c.purpose.clone(),
            retain_until: c.retain_until.clone(),
        }),
        frozen_sha256: options.frozen_sha256.clone(),
        poses: (d.head_poses && display.tracks_head)
            .then(|| poses::path_beside(&place.journal))
            .and_then(|path| path.file_name().map(|n| n.to_string_lossy().into_owned())),
    }
}
