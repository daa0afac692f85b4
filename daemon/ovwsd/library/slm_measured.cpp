#include "daemon/ovwsd/library/slm_measured.hpp"

#include <algorithm>
#include <cmath>
#include <span>

#include "core/optics/flatness.hpp"
#include "daemon/ovwsd/library/origin.hpp"
#include "daemon/shared/encoding.hpp"
#include "proto/limits.hpp"
#include "proto/tables/modes.hpp"
#include "proto/tables/origin.hpp"
#include "proto/tables/time.hpp"

namespace ovws {
namespace {

using nlohmann::json;

constexpr double kMaxRad = 1000.0;

struct LutFile {
  std::int64_t t_taken_ns = 0;
  int frames = 0, levels = 0;
  std::vector<double> phase_rad, standard_error_rad;
  double noise_rad = 0.0, residual_rad = 0.0;
  std::shared_ptr<const json> origin;
};

/// The map of what the modes leave.
struct FineFile {
  int cells = 0;
  std::string base64;  ///< float32
};
struct FlatnessFile {
  std::int64_t t_taken_ns = 0;
  int frames = 0, iterations = 0;
  double pupil_diameter_px = 0.0, residual_rms_waves = 0.0;
  std::vector<Mode> modes;
  std::vector<double> standard_error_waves;
  std::optional<std::string> configured_sha256;
  std::optional<FineFile> fine;
  std::shared_ptr<const json> origin;
};

}  // namespace

template <>
inline constexpr auto kTable<LutFile> = Fields{
    "LutFile",
    field<&LutFile::t_taken_ns>(kTimeMeaning).mandatory(),
    field<&LutFile::frames>("averaged frames", {1, limits::kReferenceFrames.max}).mandatory(),
    field<&LutFile::levels>("measured grey levels", {2, 256}).mandatory(),
    field<&LutFile::phase_rad>("phase of each grey level", {-kMaxRad, kMaxRad})
        .sized(256, 256)
        .mandatory(),
    field<&LutFile::standard_error_rad>("standard error of each phase", {0.0, kMaxRad})
        .sized(256, 256)
        .mandatory(),
    field<&LutFile::noise_rad>("noise of a measured phase", {0.0, kMaxRad}),
    field<&LutFile::residual_rad>("residual of the smoothed phases", {0.0, kMaxRad}),
    field<&LutFile::origin>("bench and settings").mandatory()};

template <>
struct Rules<LutFile> {
  static void check(const LutFile& file, ObjectReader& reader) {
    if (!std::ranges::is_sorted(file.phase_rad) &&
        !std::is_sorted(file.phase_rad.rbegin(), file.phase_rad.rend())) {
      reader.fault("phase_rad", "is not monotonic");
    }
  }
};

template <>
inline constexpr auto kTable<FineFile> =
    Fields{"FineFile", field<&FineFile::cells>("side of the map", limits::kMapCells).mandatory(),
           field<&FineFile::base64>("float32 in waves, row by row").mandatory()};

template <>
inline constexpr auto kTable<FlatnessFile> = Fields{
    "FlatnessFile",
    field<&FlatnessFile::t_taken_ns>(kTimeMeaning).mandatory(),
    field<&FlatnessFile::frames>("averaged frames", {1, limits::kReferenceFrames.max}).mandatory(),
    field<&FlatnessFile::iterations>("scans", {1, 1000}),
    field<&FlatnessFile::pupil_diameter_px>("circle of the modes", limits::kPupilDiameterPx)
        .mandatory(),
    field<&FlatnessFile::modes>("modes of the error").sized(1, kMaxZernikeIndex).mandatory(),
    field<&FlatnessFile::standard_error_waves>("of each mode", {0.0, 1e6})
        .sized(1, kMaxZernikeIndex)
        .mandatory(),
    field<&FlatnessFile::residual_rms_waves>("change in the last scan", {0.0, 1e6}),
    field<&FlatnessFile::configured_sha256>("of the map of slm.flatness; null: none").mandatory(),
    field<&FlatnessFile::fine>("what the modes leave; left out: nothing").or_left_out(),
    field<&FlatnessFile::origin>("bench and settings").mandatory()};

template <>
struct Rules<FlatnessFile> {
  static void check(const FlatnessFile& file, ObjectReader& reader) {
    const auto fits = [](const Mode& mode) {
      return mode.j >= 3 && std::abs(mode.waves) <= limits::kModeWaves.max;
    };
    if (file.modes.size() != file.standard_error_waves.size() ||
        !std::ranges::all_of(file.modes, fits)) {
      reader.fault("modes", "must have as many entries as standard_error_waves, of j = 3 and more");
    }
  }
};

json lut_content(const MeasuredLut& lut) {
  const PhaseResponse& r = lut.response;
  return to_json(LutFile{lut.t_taken_ns,
                         lut.frames,
                         r.levels,
                         {r.phase_rad.begin(), r.phase_rad.end()},
                         {r.standard_error_rad.begin(), r.standard_error_rad.end()},
                         r.noise_rad,
                         r.residual_rad,
                         std::make_shared<const json>(lut.origin)});
}

Result<MeasuredLut> lut_from(const json& content) {
  const auto file = decode<LutFile>(content);
  if (!file) return fail(file.error());
  auto parsed = parse_origin(*file->origin);
  if (!parsed) return fail(parsed.error());
  MeasuredLut lut;
  lut.t_taken_ns = file->t_taken_ns;
  lut.frames = file->frames;
  lut.response.levels = file->levels;
  std::ranges::copy(file->phase_rad, lut.response.phase_rad.begin());
  std::ranges::copy(file->standard_error_rad, lut.response.standard_error_rad.begin());
  lut.response.noise_rad = file->noise_rad;
  lut.response.residual_rad = file->residual_rad;
  lut.table = linearising_lut(lut.response.phase_rad);
  lut.key = std::move(parsed->key);
  lut.origin = *file->origin;
  return lut;
}

json flatness_content(const MeasuredFlatness& flatness) {
  FlatnessFile file{flatness.t_taken_ns,
                    flatness.frames,
                    flatness.iterations,
                    flatness.pupil_diameter_px,
                    flatness.residual_rms_waves,
                    flatness.modes,
                    flatness.standard_error_waves,
                    std::nullopt,
                    std::nullopt,
                    std::make_shared<const json>(flatness.origin)};
  if (!flatness.key.flatness_file.is_null()) {
    file.configured_sha256 = flatness.key.flatness_file.get<std::string>();
  }
  if (!flatness.fine.pixels.empty()) {
    file.fine =
        FineFile{flatness.fine.width, base64_of(std::span<const float>(flatness.fine.pixels))};
  }
  return to_json(file);
}

Result<MeasuredFlatness> flatness_from(const json& content) {
  auto file = decode<FlatnessFile>(content);
  if (!file) return fail(file.error());
  auto parsed = parse_origin(*file->origin);
  if (!parsed) return fail(parsed.error());
  MeasuredFlatness flatness;
  flatness.t_taken_ns = file->t_taken_ns;
  flatness.frames = file->frames;
  flatness.iterations = file->iterations;
  flatness.pupil_diameter_px = file->pupil_diameter_px;
  flatness.modes = std::move(file->modes);
  flatness.standard_error_waves = std::move(file->standard_error_waves);
  flatness.residual_rms_waves = file->residual_rms_waves;
  flatness.key = std::move(parsed->key);
  flatness.key.flatness_file = to_json(file->configured_sha256);
  flatness.origin = *file->origin;
  if (!file->fine) return flatness;
  const int side = file->fine->cells;
  auto values = floats_of(file->fine->base64, std::size_t(side) * std::size_t(side));
  const auto too_large = [](float waves) {
    return std::abs(waves) > float(limits::kModeWaves.max);
  };
  if (!values || std::ranges::any_of(*values, too_large)) {
    return fail(Errc::invalid, "fine", "is not a map of float32 in base64");
  }
  flatness.fine = Image<float>(side, side);
  flatness.fine.pixels = std::move(*values);
  return flatness;
}

nlohmann::json flatness_sha256(const HologramConfig& hologram) {
  if (!hologram.flatness_waves) return nullptr;
  return sha256_of(std::span<const float>(hologram.flatness_waves->pixels));
}

nlohmann::json slm_identity(const HologramConfig& hologram, bool has_lut) {
  SlmIdentity slm{hologram.slm, std::nullopt, std::nullopt};
  if (has_lut) slm.lut_sha256 = sha256_of(std::span<const std::uint8_t>(hologram.lut));
  if (const auto& dmd = hologram.dmd) {
    std::vector<double> facts{dmd->apodisation};
    facts.insert(facts.end(), dmd->amplitudes.begin(), dmd->amplitudes.end());
    slm.lut_sha256 = sha256_of(std::span<const double>(facts));
  }
  if (const auto sum = flatness_sha256(hologram); !sum.is_null()) slm.flatness_sha256 = sum;
  return to_json(slm);
}

std::shared_ptr<const ActiveSlm> active_slm(const Config& config, const HologramConfig& configured,
                                            std::shared_ptr<const MeasuredLut> lut,
                                            std::shared_ptr<const MeasuredFlatness> flatness) {
  auto slm = std::make_shared<ActiveSlm>();
  slm->hologram = configured;
  if (lut) slm->hologram.lut = lut->table.lut;
  if (flatness)
    slm->hologram.flatness_waves =
        flattened(configured, flatness->modes, flatness->fine, flatness->pupil_diameter_px);
  slm->identity = slm_identity(slm->hologram, lut || config.slm.lut);
  slm->lut = std::move(lut);
  slm->flatness = std::move(flatness);
  return slm;
}

}  // namespace ovws
