#include "daemon/ovwsd/sensor/reference_file.hpp"

#include <cmath>

#include "daemon/ovwsd/sensor/reference_origin.hpp"
#include "daemon/shared/encoding.hpp"
#include "proto/reader.hpp"
#include "proto/requests.hpp"
#include "proto/tables/sensor.hpp"
#include "proto/tables/time.hpp"

namespace ovws {
namespace {

using nlohmann::json;

constexpr std::size_t kMaxReferenceSpots = 1 << 12;
constexpr int kMaxImageSide = 1 << 16;  // width and height of the mean image

tl::unexpected<Error> invalid(std::string field, std::string reason) {
  return fail(Errc::invalid, std::move(field), std::move(reason));
}

json points_json(const std::vector<Vec2>& points) {
  json all = json::array();
  for (const Vec2& point : points) all.push_back({point.x, point.y});
  return all;
}

/// Reads a list of positions [x, y]. `allow_null`: a number may be null, which becomes NaN.
Result<std::vector<Vec2>> points_from(const json& content, const char* key, bool allow_null) {
  const auto fits = [allow_null](const json& number) {
    return number.is_number() || (allow_null && number.is_null());
  };
  const auto value = [](const json& number) {
    return number.is_null() ? NAN : number.get<double>();
  };
  if (!content.contains(key) || !content[key].is_array() ||
      content[key].size() > kMaxReferenceSpots) {
    return invalid(key, "must be a list of positions");
  }
  std::vector<Vec2> points;
  for (const json& point : content[key]) {
    const bool pair = point.is_array() && point.size() == 2 && fits(point[0]) && fits(point[1]);
    if (!pair) return invalid(key, "every entry must be a pair [x, y] of numbers");
    points.push_back({value(point[0]), value(point[1])});
  }
  return points;
}

json image_json(const ReferenceImage* picture) {
  if (picture == nullptr) return nullptr;
  return {{"frames", picture->frames},
          {"gain_db", std::isnan(picture->gain_db) ? json() : json(picture->gain_db)},
          {"pixel_format", pixel_format_name(picture->format)},
          {"width", picture->mean_dn.width},
          {"height", picture->mean_dn.height},
          {"mean_dn", base64_of(picture->mean_dn.pixels)}};
}

Result<std::shared_ptr<const ReferenceImage>> image_from(const json& content) {
  if (content.is_null()) return nullptr;
  auto picture = std::make_shared<ReferenceImage>();
  double gain_db = kUnknownGain;
  std::string format, pixels;
  int width = 0, height = 0;
  ObjectReader r(content, "picture");
  for (const char* key : {"frames", "gain_db", "pixel_format", "width", "height", "mean_dn"}) {
    r.require(key);
  }
  r.integer("frames", picture->frames, 1, ImageMean::kMaxFrames);
  if (!r.is_null("gain_db")) r.number("gain_db", gain_db, -1e3, 1e3);
  r.string("pixel_format", format);
  r.integer("width", width, 1, kMaxImageSide);
  r.integer("height", height, 1, kMaxImageSide);
  r.string("mean_dn", pixels);
  if (auto read = r.finish(); !read) return fail(read.error());
  const auto pixel_format = pixel_format_from_name(format);
  auto values = floats_of(pixels, std::size_t(width) * std::size_t(height));
  if (!pixel_format || !values)
    return invalid("picture", "does not match its pixel format, width and height");
  picture->gain_db = gain_db;
  picture->format = *pixel_format;
  picture->mean_dn.width = width;
  picture->mean_dn.height = height;
  picture->mean_dn.pixels = std::move(*values);
  return picture;
}

json beams_json(const std::vector<BeamReference>& beams) {
  json all = json::array();
  for (const BeamReference& beam : beams) {
    all.push_back({{"beam", beam.beam},
                   {"offset_px", {beam.offset_px.x, beam.offset_px.y}},
                   {"frames", beam.frames},
                   {"t_taken_ns", beam.t_taken_ns},
                   {"aberration", to_json(beam.aberration)},
                   {"introduced", to_json(beam.introduced)},
                   {"positions_px", points_json(beam.positions_px)},
                   {"standard_error_px", points_json(beam.standard_error_px)}});
  }
  return all;
}

void read_beam(ObjectReader& r, const json& content, BeamReference& beam) {
  for (const char* key : {"beam", "offset_px", "frames", "t_taken_ns", "aberration", "introduced",
                          "positions_px", "standard_error_px"}) {
    r.require(key);
  }
  std::vector<double> offset;
  r.string("beam", beam.beam);
  r.numbers("offset_px", offset, 2, 2, -1e6, 1e6);
  r.integer("frames", beam.frames, 0, 1 << 30);
  const json* const taken = r.raw("t_taken_ns");
  const json* const modes = r.raw("aberration");
  const json* const introduced = r.raw("introduced");
  r.raw("positions_px");
  r.raw("standard_error_px");
  if (r.failed()) return;
  if (!taken->is_number_integer()) return r.fault("t_taken_ns", "must be an integer");
  auto shown = ModesSet::decode({{"modes", *modes}});
  auto part = ModesSet::decode({{"modes", *introduced}});
  auto positions = points_from(content, "positions_px", false);
  auto errors = points_from(content, "standard_error_px", true);
  const bool good = shown && part && positions && errors && positions->size() == errors->size();
  if (!good) return r.fault("positions_px", "this reference of a beam is damaged");
  beam.offset_px = {offset[0], offset[1]};
  beam.t_taken_ns = taken->get<std::int64_t>();
  beam.aberration = std::move(shown->modes);
  beam.introduced = std::move(part->modes);
  beam.positions_px = std::move(*positions);
  beam.standard_error_px = std::move(*errors);
}

/// Checks that the parts of a reference agree in size.
Result<void> check_sizes(const Reference& reference) {
  const ReferenceKey& key = reference.key;
  const std::size_t spots = reference.positions_px.size();
  for (const BeamReference& beam : reference.beams) {
    if (beam.positions_px.size() == spots) continue;
    return invalid("beams", "every beam must have as many positions as positions_px");
  }
  if (spots == 0 || reference.standard_error_px.size() != spots) {
    return invalid("positions_px", "must not be empty, and must be as long as standard_error_px");
  }
  const auto* const picture = reference.picture.get();
  if (picture != nullptr &&
      (picture->mean_dn.width != key.roi.width || picture->mean_dn.height != key.roi.height)) {
    return invalid("picture", "must have the size of the region of interest");
  }
  return {};
}

}  // namespace

json reference_content(const Reference& reference) {
  json content{{"source", reference_source_name(reference.source)},
               {"frames", reference.frames},
               {"t_taken_ns", reference.t_taken_ns},
               {"t_taken", utc_text(reference.t_taken_ns)},
               {"positions_px", points_json(reference.positions_px)},
               {"standard_error_px", points_json(reference.standard_error_px)},
               {"origin", reference.origin ? *reference.origin : json()},
               {"picture", image_json(reference.picture.get())}};
  if (!reference.beams.empty()) content["beams"] = beams_json(reference.beams);
  return content;
}

Result<Reference> reference_from(const json& content) {
  Reference reference;
  int source = -1;
  std::string t_taken;
  ObjectReader r(content, "");
  for (const char* key : {"source", "frames", "t_taken_ns", "origin", "picture"}) r.require(key);
  r.choice("source", source,
           {std::string(reference_source_name(ReferenceSource::measured)),
            std::string(reference_source_name(ReferenceSource::model))});
  r.integer("frames", reference.frames, 0, 1 << 30);
  r.string("t_taken", t_taken);
  const json* const t_taken_ns = r.raw("t_taken_ns");
  const json* const origin = r.raw("origin");
  const json* const picture = r.raw("picture");
  std::vector<BeamReference> beams;
  r.objects("beams", kMaxBeams, [&](ObjectReader& in, std::size_t k) {
    read_beam(in, content["beams"][k], beams.emplace_back());
  });
  r.raw("positions_px");
  r.raw("standard_error_px");
  if (auto read = r.finish(); !read) return fail(read.error());
  if (!t_taken_ns->is_number_integer())
    return invalid("t_taken_ns", "must be a time in nanoseconds");
  if (!origin->is_object()) return invalid("origin", "must be an object");
  reference.source = ReferenceSource(source);
  reference.t_taken_ns = t_taken_ns->get<std::int64_t>();
  auto positions = points_from(content, "positions_px", false);
  if (!positions) return fail(positions.error());
  auto errors = points_from(content, "standard_error_px", true);
  if (!errors) return fail(errors.error());
  auto parsed = ReferenceBench::parse(*origin);
  if (!parsed) return fail(parsed.error());
  auto mean = image_from(*picture);
  if (!mean) return fail(mean.error());
  reference.key = parsed->key;
  reference.beams = std::move(beams);
  reference.aberration = std::move(parsed->aberration);
  reference.introduced = std::move(parsed->introduced);
  reference.registration = parsed->registration;
  reference.positions_px = std::move(*positions);
  reference.standard_error_px = std::move(*errors);
  reference.origin = std::make_shared<const json>(*origin);
  reference.picture = std::move(*mean);
  if (auto sizes = check_sizes(reference); !sizes) return fail(sizes.error());
  return reference;
}

}  // namespace ovws
