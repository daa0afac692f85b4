/// Templates of the spots that one wavefront makes: what follows those that it has torn.
#pragma once

#include <Eigen/Core>
#include <memory>
#include <span>
#include <vector>

#include "core/optics/spot_optics.hpp"
#include "core/tracking/template_bank.hpp"

namespace ovws {

/// For each subaperture that is `wanted` its template, else null; the modes `waves` in the order of
/// the optics', whose cells must be camera pixels. Its place is where the wavefront's mean slope
/// puts the spot. Some 30 ms each: off the frame path.
std::vector<std::shared_ptr<const TemplateBank>> shape_templates(const SpotOptics& optics,
                                                                 const SpotModel& spots,
                                                                 const Eigen::VectorXd& waves,
                                                                 const std::vector<bool>& wanted);

}  // namespace ovws
