/// Light on the camera: exposure, and what changes between two images.
#pragma once

#include <initializer_list>
#include <optional>
#include <string>

#include "core/base/image.hpp"
#include "core/base/result.hpp"
#include "daemon/examine/commission/bench.hpp"

namespace ovws::commission {

/// What a change of exposure and pattern replaces.
constexpr std::initializer_list<cli::Part> kLight{cli::Part::pattern, cli::Part::camera};

float brightest(const Image<float>& image);

/// Automatic exposure for what the SLM shows. The result of camera.auto_exposure.
Result<nlohmann::json> expose(Bench& bench);
/// The same for the sensor's spots, which the SLM shows from then on. If it fails, pattern and
/// exposure are as before.
Result<nlohmann::json> expose_spots(Bench& bench);
/// A spot that is in one image and not in another one.
struct Spot {
  double x = 0.0, y = 0.0;  ///< centre of intensity, pixels
};
/// None: nothing compact is brighter in `with`.
std::optional<Spot> spot_in(const Image<float>& with, const Image<float>& without);

/// The largest change between two images, relative to that between two images of the same thing, in
/// cells of 16 x 16 pixels; above 1: they differ beyond the noise.
double change(const Image<float>& one, const Image<float>& other, const Image<float>& one_again);

}  // namespace ovws::commission
