/// Configuration of the twin: the simulated bench. Every key has a default; `{}` is valid.
#pragma once

#include <complex>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "core/base/result.hpp"
#include "core/optics/detector.hpp"
#include "core/optics/geometry.hpp"
#include "core/optics/zernike.hpp"
#include "drivers/twin/array_config.hpp"
#include "drivers/twin/deformable_mirror.hpp"
#include "drivers/twin/dmd.hpp"
#include "drivers/twin/scintillation.hpp"
#include "drivers/twin/turbulence.hpp"
#include "proto/reader.hpp"

namespace ovws::twin {

struct CameraConfig {
  std::string address = "127.0.0.1";  ///< IPv4 address of an interface of this machine, port 3956
  std::string serial = "TWIN0001";
  int sensor_width = 1024;
  int sensor_height = 1024;
};

/// True response of the SLM, which the daemon does not know. The phase of grey level g is
/// 2 pi depth_waves (g / 256)^gamma plus the flatness error of the surface. With a negative
/// depth_waves the phase falls.
struct SlmConfig {
  std::string display = "DUMMY1";  ///< output name on the X server; empty: none, the SLM is off
  SlmGeometry geometry;            ///< keys width, height, pitch_um
  double gamma = 1.0;
  double depth_waves = 1.0;
  double flatness_rms_waves = 0.0;  ///< RMS over the SLM of a smooth random flatness error
  int flatness_seed = 1;
  double flatness_cycles = 2.5;  ///< shortest wave of the flatness error, cycles per SLM height
  double settle_ms = 0.0;        ///< delay of the liquid crystal, which then changes in one step
};

enum class Mirror { none, x, y };

/// Orientation, scale and position of the camera in the far field; camera_map.hpp defines the map.
struct CameraGeometry {
  double rotation_deg = 0.0;
  Mirror mirror = Mirror::none;
  double magnification = 1.0;
  Vec2 centre_px{255.5, 255.5};  ///< position of the base grating's spot on the sensor, not the ROI

  friend bool operator==(const CameraGeometry&, const CameraGeometry&) = default;
};

enum class LightShape { uniform, gaussian };

struct LightConfig {
  LightShape shape = LightShape::uniform;
  double diameter_px = 1200.0;  ///< 1/e^2 diameter of a Gaussian beam, SLM pixels
};

/// Shade: a disc in front of the SLM that dims the beam.
struct Shade {
  Vec2 centre_px;  ///< centre of the disc, SLM pixels
  double radius_px = 0.0;
  double transmission = 0.0;  ///< transmitted fraction of the intensity

  bool operator==(const Shade&) const = default;
};

/// Branch point: a phase singularity of the light on the SLM, dark in its core.
struct LightVortex {
  Vec2 at;  ///< pupil radii from the pupil's centre
  int charge = 1;

  bool operator==(const LightVortex&) const = default;
};
/// Factor on the light at a place in pupil radii: the vortex's phase, and its dark core.
std::complex<float> field_about(const LightVortex& vortex, Vec2 at);

enum class Noise {
  fresh,  ///< new noise for each frame; if generation is too slow, an old frame repeats (counted)
  pool,   ///< 32 noise realisations in turn: little CPU load
  none,   ///< no noise: the mean image, quantised
};

/// A further source of light, incoherent with the main one: it gives the same picture, with an
/// aberration of its own, displaced on the camera.
struct LightSource {
  Vec2 offset_px;      ///< camera pixels
  double power = 1.0;  ///< relative to the main source
  std::vector<Mode> aberration;

  bool operator==(const LightSource&) const = default;
};

/// The light in front of the sensor, except for turbulence.
struct Light {
  /// Aberration of the light on the sensor, as Zernike modes over its pupil.
  std::vector<Mode> aberration;
  std::vector<Shade> shades{};
  /// Of each actuator of the deformable mirror, waves; empty: all 0.
  std::vector<double> mirror_waves{};
  std::optional<ScintillationConfig> scintillation{};
  std::vector<LightVortex> branch_points{};
  std::vector<LightSource> sources{};  ///< the further ones

  friend bool operator==(const Light&, const Light&) = default;
};

/// Ground truth: bench parameters that can change while the twin runs and that only it knows.
struct Truth : Light {
  /// Laser power, as electrons in the brightest pixel of an ideal charge-1 spot after
  /// kReferenceExposureUs. At equal power the peak of a charge-0 spot is 3.9 times higher.
  /// Interference with neighbouring spots raises a charge-1 peak by a factor of 1.2 to 1.4.
  double peak_electrons = 6000.0;
  CameraGeometry geometry;
  std::optional<TurbulenceConfig> turbulence;
  DetectorConfig detector;      ///< detector.bits is not used: see `bits` below
  int bits = 0;                 ///< bits of the A/D converter; 0: as many as the pixel format has
  bool left_justified = false;  ///< MSB-aligned: 10 to 14 bits in the high bits of 16
  Noise noise = Noise::fresh;
};

/// What makes the spots: the SLM behind a lens, a fixed array of lenslets, or a DMD in the SLM's
/// place, whose mirrors are on for grey levels from 128 (video mode) or by the bits of the colours.
enum class Modulator { slm, fixed, dmd };

struct Config {
  Modulator modulator = Modulator::slm;
  CameraConfig camera;
  PatternMode dmd;    ///< Modulator::dmd only
  ArrayConfig array;  ///< Modulator::fixed only; slm and most of sensor are then not used
  SlmConfig slm;
  OpticsConfig optics;  ///< truth.geometry replaces its magnification and centre_px
  SensorConfig sensor;  ///< sensor of the expected hologram: pupil and spot positions
  LightConfig light;
  std::optional<MirrorConfig> mirror;  ///< deformable mirror over the pupil; none: there is none
  Truth truth;
  std::string control_endpoint = "tcp://127.0.0.1:7790";
};

const std::vector<std::string>& mirror_names();  ///< names of Mirror, in its order

constexpr double kReferenceExposureUs = 2000.0;
/// Peak far-field amplitude |F| of a charge-1 vortex behind a uniform circular aperture, in units
/// of the aperture's area: the maximum over q of 2 integral_0^1 J1(q t) t dt, at q = 2.4525.
constexpr double kVortexPeak = 0.508681;

/// Parses the configuration from JSON text strictly, but allows comments. Errors (Errc::invalid)
/// name the dotted path of the key.
Result<Config> parse_config(const std::string& json_text);
/// Loads a configuration file. The reason of an error names the file.
Result<Config> load_config(const std::string& path);

/// Readers of ground-truth keys from an object: `aberration`, `norm`, `shades`, `noise` ...
void read_aberration(ObjectReader& reader, std::vector<Mode>& aberration);
void read_shades(ObjectReader& reader, Truth& truth);
void read_branch_points(ObjectReader& reader, Truth& truth);
void read_sources(ObjectReader& reader, Truth& truth);
void read_detector(ObjectReader& reader, Truth& truth);
void read_noise(ObjectReader& reader, Truth& truth);
/// Reads the key `turbulence`. null switches the turbulence off. An object replaces the whole
/// configuration, with defaults for missing keys. Without the key, the turbulence is unchanged.
void read_turbulence(ObjectReader& reader, std::optional<TurbulenceConfig>& turbulence);
/// Reads the key `scintillation` in the same way.
void read_scintillation(ObjectReader& reader, std::optional<ScintillationConfig>& scintillation);
/// Reads the object `geometry` of twin.set; missing keys keep their values.
void read_geometry(ObjectReader& reader, CameraGeometry& geometry);

}  // namespace ovws::twin
