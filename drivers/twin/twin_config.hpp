/// Configuration of the twin: the simulated bench. Every key has a default; `{}` is valid.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "core/base/result.hpp"
#include "core/optics/detector.hpp"
#include "core/optics/geometry.hpp"
#include "core/optics/zernike.hpp"
#include "drivers/twin/turbulence.hpp"
#include "proto/reader.hpp"

namespace ovws::twin {

struct CameraConfig {
  std::string address = "127.0.0.1";  ///< of a network interface of this machine; UDP port 3956
  std::string serial = "TWIN0001";
  int sensor_width = 1024;
  int sensor_height = 1024;
};

/// True response of the SLM, which the daemon does not know: phase = 2 pi depth_waves (g /
/// 256)^gamma for grey level g, falling if depth_waves is negative, plus the flatness error of its
/// surface.
struct SlmConfig {
  std::string display = "DUMMY1";  ///< output name on the X server
  SlmGeometry geometry;            ///< keys width, height, pitch_um
  double gamma = 1.0;
  double depth_waves = 1.0;
  double flatness_rms_waves = 0.0;  ///< of a smooth random surface, RMS over the SLM
  int flatness_seed = 1;
  double flatness_cycles = 2.5;  ///< cycles of its shortest wave over the SLM's height
  double settle_ms = 0.0;        ///< delay until the liquid crystal follows the display, at once
};

enum class Mirror { none, x, y };

/// Orientation, scale and position of the camera in the far field; camera_map.hpp defines the map.
struct CameraGeometry {
  double rotation_deg = 0.0;
  Mirror mirror = Mirror::none;
  double magnification = 1.0;
  Vec2 centre_px{255.5, 255.5};  ///< of the *sensor* (not of the ROI): where the base spot falls

  friend bool operator==(const CameraGeometry&, const CameraGeometry&) = default;
};

enum class LightShape { uniform, gaussian };

struct LightConfig {
  LightShape shape = LightShape::uniform;
  double diameter_px = 1200.0;  ///< SLM pixels: 1/e^2 diameter of a Gaussian beam; else not used
};

/// A disc in the beam, in front of the SLM.
struct Shade {
  Vec2 centre_px;  ///< SLM pixels
  double radius_px = 0.0;
  double transmission = 0.0;  ///< transmitted fraction of the intensity

  bool operator==(const Shade&) const = default;
};

enum class Noise {
  fresh,  ///< a new realisation for each frame; if generation is too slow, an old one, counted
  pool,   ///< 32 realisations in turn: little CPU load
  none,   ///< the mean image, quantised
};

/// Ground truth: what can change while the twin runs, and only the twin knows.
struct Truth {
  /// Aberration of the light on the SLM, over the sensor's pupil.
  std::vector<Mode> aberration;
  std::vector<Shade> shades;
  /// Laser power, as electrons in the brightest pixel of an ideal charge-1 spot after
  /// kReferenceExposureUs. At the same power a charge-0 spot peaks 3.9 times higher, and
  /// interference with neighbouring spots raises a charge-1 peak by 1.2 to 1.4.
  double peak_electrons = 6000.0;
  CameraGeometry geometry;
  std::optional<TurbulenceConfig> turbulence;
  DetectorConfig detector;      ///< its `bits` is not used
  int bits = 0;                 ///< of the A/D converter; 0: as many as the pixel format has
  bool left_justified = false;  ///< MSB-aligned: 10 to 14 bits in the high bits of 16
  Noise noise = Noise::fresh;
};

struct Config {
  CameraConfig camera;
  SlmConfig slm;
  OpticsConfig optics;  ///< magnification and centre_px are not used: truth.geometry has them
  SensorConfig sensor;  ///< expected hologram: its pupil and spot positions
  LightConfig light;
  Truth truth;
  std::string control_endpoint = "tcp://127.0.0.1:7790";
};

const std::vector<std::string>& mirror_names();  ///< in the order of Mirror

constexpr double kReferenceExposureUs = 2000.0;
/// Greatest |F| of a charge-1 vortex behind a uniform circular aperture, in units of the
/// aperture's area: the maximum over q of 2 integral_0^1 J1(q t) t dt, at q = 2.4525.
constexpr double kVortexPeak = 0.508681;

/// Strict decoding of JSON text, in which comments are allowed. Errors (Errc::invalid) name the
/// dotted path.
Result<Config> parse_config(const std::string& json_text);
/// Reads a configuration file. The error's reason names the file.
Result<Config> load_config(const std::string& path);

/// Reads the keys of Truth from an object: `aberration`, `norm`, and `peak_electrons` …
void read_aberration(ObjectReader& reader, Truth& truth);
void read_shades(ObjectReader& reader, Truth& truth);
void read_detector(ObjectReader& reader, Truth& truth);
void read_noise(ObjectReader& reader, Truth& truth);
/// Reads the key `turbulence`: null switches it off; an object replaces it as a whole, with
/// defaults for missing keys. Without the key it stays.
void read_turbulence(ObjectReader& reader, std::optional<TurbulenceConfig>& turbulence);
/// The object `geometry` of twin.set: any of its keys.
void read_geometry(ObjectReader& reader, CameraGeometry& geometry);

/// Mean photons from one subaperture to the camera in kReferenceExposureUs, and the inverse.
double photons_per_spot(const Config& config, const Truth& truth);
double peak_electrons_for(const Config& config, const Truth& truth, double photons);

}  // namespace ovws::twin
