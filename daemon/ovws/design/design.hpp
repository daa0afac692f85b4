/// Design of a bench: from wavelength, lens, SLM, camera and beam to a configuration of the daemon,
/// or to what makes it impossible and the changes that help. Pure functions: no device, no file.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "config/config.hpp"

namespace ovws::design {

/// The parts of a bench, and what is wanted from it.
struct Bench {
  double wavelength_nm = 632.0;
  double focal_length_mm = 200.0;
  double magnification = 1.0;
  SlmGeometry slm;
  double settle_ms = 20.0;
  int sensor_width = 2048;  ///< camera sensor, pixels
  int sensor_height = 1536;
  double camera_pitch_um = 3.45;
  PixelFormat pixel_format = PixelFormat::mono8;
  std::optional<double> beam_mm;  ///< beam diameter on the SLM; none: it covers the pupil
  std::optional<int> modes;       ///< at least this number of modes; none: any number
  int charge = 1;
};

/// The bench that a configuration describes; its camera sensor is the configured region.
Bench bench_of(const Config& config);

/// What limits a bench, or makes it impossible.
enum class Limit {
  region,      ///< spots outside the camera's sensor
  neighbours,  ///< neighbouring spots too close together
  scale,       ///< lambda/d too small or too large on the camera
  grating,     ///< a grating too fine for the SLM's pixels
  orders,      ///< other diffraction orders among the spots
  modes,       ///< too few subapertures for the modes
  beam,        ///< the beam does not cover the SLM
};

/// A limit with what it means here and, if something helps, what.
struct Finding {
  Limit limit{};
  std::string reason;
  std::string help;  ///< empty: nothing needs to be done
};

/// A single change of the bench, or one with a second change, that makes it possible.
struct Change {
  std::string options;  ///< command-line options, "--focal-length 150"
  std::string meaning;
  Bench bench;  ///< the changed bench: design() accepts it
};

/// Key figures of a designed bench. Lengths on the camera in its pixels.
struct Figures {
  int subapertures = 0;
  int modes = 0;                        ///< that are measured
  int modes_by_positions = 0;           ///< that the spots' positions determine
  double pupil_mm = 0.0;                ///< the beam must cover it
  double subaperture_mm = 0.0;          ///< d
  double subaperture_px = 0.0;          ///< d, SLM pixels
  double lambda_d_px = 0.0;             ///< scale of one spot
  double neighbours = 0.0;              ///< smallest distance of two spots, lambda/d
  double range_waves = 0.0;             ///< slope over one subaperture that a spot can follow
  double range_defocus_waves = 0.0;     ///< coefficient of Z(2,0) with that slope at the edge
  double grating_period_px = 0.0;       ///< of the base grating, SLM pixels
  double finest_period_px = 0.0;        ///< of the finest grating, SLM pixels
  std::vector<double> zeroth_order_px;  ///< from the zeroth order to the base spot, [x, y]
  std::vector<double> zeroth_order_mm;  ///< the same in the camera's plane
};

struct Design {
  Config config;
  Figures figures;
  std::vector<Finding> findings;  ///< what limits it
};

struct Refusal {
  Finding finding;
  std::vector<Change> changes;  ///< empty: no change was found that suffices
};

/// Designs a bench. The result's configuration passes check_sensor and check_sees_spots; its other
/// keys are those of `base`. Deterministic, thread-safe. Takes some milliseconds, or up to seconds
/// if the bench is refused or its modes need the spots' shapes.
tl::expected<Design, Refusal> design(const Bench& bench, const Config& base = {});

}  // namespace ovws::design
