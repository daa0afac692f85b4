/// Templates computed for a given wavefront, to track the spots that it has split.
#pragma once

#include <Eigen/Core>
#include <memory>
#include <span>
#include <vector>

#include "core/optics/spot_optics.hpp"
#include "core/tracking/template_bank.hpp"

namespace ovws {

/// The spot model for shape_templates, with about 49 bins per lambda/d. `px_per_cycle` and `spots`
/// are in pixels of the lit colour plane.
SpotOptics template_optics(const Lattice& lattice, const SensorConfig& sensor,
                           const std::vector<int>& modes_j, const PxPerCycle& px_per_cycle,
                           const SpotModel& spots);

/// The template of each `wanted` subaperture; null for the others, and where it is singular.
/// `optics` as from template_optics; `waves` in the order of its modes. The template's position is
/// where the wavefront's mean slope puts the spot. Takes about 8 ms each: off the frame path.
std::vector<std::shared_ptr<const TemplateBank>> shape_templates(const SpotOptics& optics,
                                                                 const SpotModel& spots,
                                                                 const Eigen::VectorXd& waves,
                                                                 const std::vector<bool>& wanted);

}  // namespace ovws
