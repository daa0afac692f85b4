/// Templates of the spots that one wavefront makes: what follows those that it has torn.
#pragma once

#include <Eigen/Core>
#include <memory>
#include <span>
#include <vector>

#include "core/optics/spot_optics.hpp"
#include "core/tracking/template_bank.hpp"

namespace ovws {

/// What shape_templates needs: cells some 49 a lambda/d. `px_per_cycle` and `spots` in pixels of
/// the lit lattice.
SpotOptics template_optics(const Lattice& lattice, const SensorConfig& sensor,
                           const std::vector<int>& modes_j, const PxPerCycle& px_per_cycle,
                           const SpotModel& spots);

/// For each subaperture that is `wanted` its template, else null; `optics` as of template_optics,
/// the modes `waves` in the order of the optics'. Its place is where the wavefront's mean slope
/// puts the spot. Some 8 ms each: off the frame path.
std::vector<std::shared_ptr<const TemplateBank>> shape_templates(const SpotOptics& optics,
                                                                 const SpotModel& spots,
                                                                 const Eigen::VectorXd& waves,
                                                                 const std::vector<bool>& wanted);

}  // namespace ovws
