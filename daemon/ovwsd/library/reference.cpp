#include "daemon/ovwsd/library/reference.hpp"

#include <cmath>

#include "daemon/ovwsd/library/origin.hpp"
#include "daemon/shared/encoding.hpp"
#include "proto/tables/modes.hpp"
#include "proto/tables/time.hpp"

namespace ovws {
namespace {

constexpr std::size_t kMaxReferenceSpots = 1 << 12;
constexpr double kMaxFrames = 1 << 30;

/// The mean image in a file.
struct ImageFile {
  int frames = 0;
  double gain_db = kUnknownGain;
  PixelFormat pixel_format = PixelFormat::mono8;
  int width = 0, height = 0;
  std::string mean_dn;  ///< float32 in base64
};

}  // namespace

template <>
inline constexpr auto kTable<ImageFile> =
    Fields{"ImageFile",
           field<&ImageFile::frames>("averaged frames", {1, ImageMean::kMaxFrames}).mandatory(),
           field<&ImageFile::gain_db>("gain, dB", {-1e3, 1e3}).or_null().mandatory(),
           field<&ImageFile::pixel_format>("GenICam name").mandatory(),
           field<&ImageFile::width>("width, pixels", {1, 1 << 16}).mandatory(),
           field<&ImageFile::height>("height, pixels", {1, 1 << 16}).mandatory(),
           field<&ImageFile::mean_dn>("DN, float32 row by row in base64").mandatory()};

template <>
struct Wire<std::shared_ptr<const ReferenceImage>> {
  static Json to_json(const std::shared_ptr<const ReferenceImage>& image) {
    if (!image) return nullptr;
    return ovws::to_json(ImageFile{image->frames, image->gain_db, image->format,
                                   image->mean_dn.width, image->mean_dn.height,
                                   base64_of(image->mean_dn.pixels)});
  }
  static void decode(ObjectReader& reader, const FieldInfo& field,
                     std::shared_ptr<const ReferenceImage>& out) {
    if (!reader.has(field.key) || reader.is_null(field.key)) return;
    ImageFile file;
    reader.object(field.key, [&](ObjectReader& inner) { detail::decode_fields(inner, file); });
    if (reader.failed()) return;
    auto pixels = floats_of(file.mean_dn, std::size_t(file.width) * std::size_t(file.height));
    if (!pixels) return reader.fault(field.key, "does not match its width and height");
    ReferenceImage image{file.frames, file.gain_db, kUnknownGain, file.pixel_format, {}};
    image.mean_dn = Image<float>(file.width, file.height);
    image.mean_dn.pixels = std::move(*pixels);
    out = std::make_shared<const ReferenceImage>(std::move(image));
  }
};

template <>
inline constexpr auto kTable<SourceReference> =
    Fields{"SourceReference",
           field<&SourceReference::frames>("averaged frames", {0, kMaxFrames}).mandatory(),
           field<&SourceReference::t_taken_ns>(kTimeMeaning).mandatory(),
           field<&SourceReference::positions_px>("[x, y] of each spot")
               .sized(1, kMaxReferenceSpots)
               .mandatory(),
           field<&SourceReference::standard_error_px>("[x, y] of each spot; null: it was lost")
               .sized(1, kMaxReferenceSpots)
               .with_nulls()
               .mandatory()};

template <>
inline constexpr auto kTable<BeamReference> =
    Fields{"BeamReference",
           field<&BeamReference::beam>("name of the source").mandatory(),
           field<&BeamReference::offset_px>("[x, y], as configured", {-1e6, 1e6}).mandatory(),
           based<SourceReference>(),
           field<&BeamReference::aberration>("modes shown").mandatory(),
           field<&BeamReference::introduced>("modes introduced").mandatory()};

template <>
inline constexpr auto kTable<Reference> =
    Fields{"ReferenceFile",
           field<&Reference::source>("measured, or predicted").mandatory(),
           based<SourceReference>(),
           time_text("t_taken", &Reference::t_taken_ns),
           field<&Reference::origin>("bench and settings").mandatory(),
           field<&Reference::picture>("mean image").mandatory(),
           field<&Reference::beams>("of the further sources").sized(0, kMaxBeams).or_left_out()};

template <>
struct Rules<Reference> {
  static void check(const Reference& reference, ObjectReader& reader) {
    const std::size_t spots = reference.positions_px.size();
    const auto has_all = [spots](const auto& one) {
      return one.positions_px.size() == spots && one.standard_error_px.size() == spots;
    };
    if (!has_all(reference)) {
      return reader.fault("positions_px", "must be as long as standard_error_px");
    }
    if (!std::ranges::all_of(reference.beams, has_all)) {
      reader.fault("beams", "every beam must have as many positions as positions_px");
    }
  }
};

nlohmann::json reference_content(const Reference& reference) {
  return to_json(reference);
}

Result<Reference> reference_from(const nlohmann::json& content) {
  auto reference = decode<Reference>(content);
  if (!reference) return reference;
  auto parsed = parse_origin(*reference->origin);
  if (!parsed) return fail(parsed.error());
  reference->key = std::move(parsed->key);
  reference->aberration = std::move(parsed->aberration);
  reference->introduced = std::move(parsed->introduced);
  reference->registration = parsed->registration;
  const ReferenceImage* const picture = reference->picture.get();
  const Roi& roi = reference->key.roi;
  if (picture != nullptr &&
      (picture->mean_dn.width != roi.width || picture->mean_dn.height != roi.height)) {
    return fail(Errc::invalid, "picture", "must have the size of the region of interest");
  }
  return reference;
}

double rms_waves(const std::vector<Mode>& modes) {
  double square = 0.0;
  for (const Mode& mode : modes) square += mode.waves * mode.waves;
  return std::sqrt(square);
}

}  // namespace ovws
