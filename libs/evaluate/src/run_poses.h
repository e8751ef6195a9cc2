// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "cf/types/sim3.h"
#include "run_inputs.h"
#include "run_section.h"

namespace cf {

/// Photos with a pose among those of the truth.
Json photoFigures(const RunInputs& run);

/// Errors of the camera poses under three alignments of the cluster, and by UAV.
RunSection trajectoryFigures(const RunInputs& run);

/// How each pair of UAVs lies to each other: the rigid motion that best takes a UAV's true poses to
/// its estimated ones, scaled by the cluster's similarity `S_ref_est`, against the other UAV's.
RunSection pairFigures(const RunInputs& run, const Sim3& S_ref_est);

/// Whether the covariances that the run tells of its poses are those of their errors.
RunSection consistencyFigures(const RunInputs& run);

/// The relative poses that the run observed between UAVs.
RunSection relativePoseFigures(const RunInputs& run);

/// The similarity of all UAVs' camera centres together onto the truth.
Result<Sim3> alignCluster(const RunInputs& run);

}  // namespace cf
