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
  MeasuredLut lut;
  std::vector<double> phase_rad, standard_error_rad;
};

struct FlatnessFile {
  MeasuredFlatness flatness;
  std::optional<std::string> configured_sha256;
  std::optional<PupilPicture> fine;
};

}  // namespace

template <>
inline constexpr auto kTable<PhaseResponse> = Fields{
    "PhaseResponse", field<&PhaseResponse::levels>("measured grey levels", {2, 256}).mandatory(),
    field<&PhaseResponse::noise_rad>("noise of a measured phase", {0.0, kMaxRad}),
    field<&PhaseResponse::residual_rad>("residual of the smoothed phases", {0.0, kMaxRad})};

template <>
inline constexpr auto kTable<MeasuredLut> = Fields{
    "MeasuredLut", field<&MeasuredLut::t_taken_ns>(kTimeMeaning).mandatory(),
    field<&MeasuredLut::frames>("averaged frames", {1, limits::kReferenceFrames.max}).mandatory(),
    inlined(&MeasuredLut::response), field<&MeasuredLut::origin>("bench and settings").mandatory()};

template <>
inline constexpr auto kTable<LutFile> =
    Fields{"LutFile", inlined(&LutFile::lut),
           field<&LutFile::phase_rad>("phase of each grey level", {-kMaxRad, kMaxRad})
               .sized(256, 256)
               .mandatory(),
           field<&LutFile::standard_error_rad>("standard error of each phase", {0.0, kMaxRad})
               .sized(256, 256)
               .mandatory()};

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
inline constexpr auto kTable<MeasuredFlatness> = Fields{
    "MeasuredFlatness",
    field<&MeasuredFlatness::t_taken_ns>(kTimeMeaning).mandatory(),
    field<&MeasuredFlatness::frames>("averaged frames", {1, limits::kReferenceFrames.max})
        .mandatory(),
    field<&MeasuredFlatness::iterations>("scans", {1, 1000}),
    field<&MeasuredFlatness::pupil_diameter_px>("circle of the modes", limits::kPupilDiameterPx)
        .mandatory(),
    field<&MeasuredFlatness::modes>("modes of the error").sized(1, kMaxZernikeIndex).mandatory(),
    field<&MeasuredFlatness::standard_error_waves>("of each mode", {0.0, 1e6})
        .sized(1, kMaxZernikeIndex)
        .mandatory(),
    field<&MeasuredFlatness::residual_rms_waves>("change in the last scan", {0.0, 1e6}),
    field<&MeasuredFlatness::origin>("bench and settings").mandatory()};

template <>
inline constexpr auto kTable<FlatnessFile> = Fields{
    "FlatnessFile", inlined(&FlatnessFile::flatness),
    field<&FlatnessFile::configured_sha256>("of the map of slm.flatness; null: none").mandatory(),
    field<&FlatnessFile::fine>("what the modes leave; left out: nothing").or_left_out()};

template <>
struct Rules<MeasuredFlatness> {
  static void check(const MeasuredFlatness& flatness, ObjectReader& reader) {
    const auto fits = [](const Mode& mode) {
      return mode.j >= 3 && std::abs(mode.waves) <= limits::kModeWaves.max;
    };
    if (flatness.modes.size() != flatness.standard_error_waves.size() ||
        !std::ranges::all_of(flatness.modes, fits)) {
      reader.fault("modes", "must have as many entries as standard_error_waves, of j = 3 and more");
    }
  }
};

json lut_content(const MeasuredLut& lut) {
  const PhaseResponse& r = lut.response;
  return to_json(LutFile{lut,
                         {r.phase_rad.begin(), r.phase_rad.end()},
                         {r.standard_error_rad.begin(), r.standard_error_rad.end()}});
}

Result<MeasuredLut> lut_from(const json& content) {
  auto file = decode<LutFile>(content);
  if (!file) return fail(file.error());
  MeasuredLut& lut = file->lut;
  auto parsed = parse_origin(*lut.origin);
  if (!parsed) return fail(parsed.error());
  std::ranges::copy(file->phase_rad, lut.response.phase_rad.begin());
  std::ranges::copy(file->standard_error_rad, lut.response.standard_error_rad.begin());
  lut.table = linearising_lut(lut.response.phase_rad);
  lut.key = std::move(parsed->key);
  return std::move(lut);
}

PupilPicture picture_of(const Image<float>& map) {
  return {map.width, base64_of(std::span<const float>(map.pixels))};
}

json flatness_content(const MeasuredFlatness& flatness) {
  FlatnessFile file{flatness, std::nullopt, std::nullopt};
  if (!flatness.key.flatness_file.is_null()) {
    file.configured_sha256 = flatness.key.flatness_file.get<std::string>();
  }
  if (!flatness.fine.pixels.empty()) file.fine = picture_of(flatness.fine);
  return to_json(file);
}

Result<MeasuredFlatness> flatness_from(const json& content) {
  auto file = decode<FlatnessFile>(content);
  if (!file) return fail(file.error());
  MeasuredFlatness& flatness = file->flatness;
  auto parsed = parse_origin(*flatness.origin);
  if (!parsed) return fail(parsed.error());
  flatness.key = std::move(parsed->key);
  flatness.key.flatness_file = to_json(file->configured_sha256);
  if (!file->fine) return std::move(flatness);
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
  return std::move(flatness);
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
