#include "proto/requests.hpp"

#include <set>
#include <string>
#include <utility>

#include "proto/field_schema.hpp"
#include "proto/names.hpp"
#include "proto/reader.hpp"
#include "proto/tables/modes.hpp"

namespace ovws {
namespace {

/// Reads the OSA/ANSI index of a Zernike mode, from `j` or from `n` and `m`.
int read_mode_index(ObjectReader& reader) {
  int j = 0, n = 0, m = 0;
  const bool by_j = reader.has("j");
  reader.integer("j", j, 0, kMaxZernikeIndex);
  if (!by_j) {
    reader.require("n");
    reader.require("m");
  }
  reader.integer("n", n, 0, 1000);
  reader.integer("m", m, -1000, 1000);
  if (reader.failed()) return 0;
  if (by_j && (reader.has("n") || reader.has("m"))) {
    reader.fault("j", "give either j, or n and m, not both");
  }
  if (by_j) return j;
  const auto index = checked_osa_index(n, m);
  if (!index) {
    reader.fault("n",
                 "there is no mode with n = " + std::to_string(n) + ", m = " + std::to_string(m) +
                     ": |m| <= n, n - |m| even, and j at most " + std::to_string(kMaxZernikeIndex));
  }
  return index.value_or(0);
}

}  // namespace

Result<ModesSet> ModesSet::decode(const Json& params) {
  std::vector<Mode> modes;
  std::set<int> given;
  ObjectReader reader(params, "");
  int norm = 0;
  reader.choice("norm", norm, kNames<ZernikeNorm>());
  reader.require("modes");
  reader.objects("modes", kMaxZernikeIndex + 1, [&](ObjectReader& r, std::size_t) {
    Mode mode;
    mode.j = read_mode_index(r);
    r.require("waves");
    r.number("waves", mode.waves, limits::kModeWaves.min, limits::kModeWaves.max);
    if (r.failed()) return;
    if (!given.insert(mode.j).second) {
      r.fault("", "the mode j = " + std::to_string(mode.j) + " is given twice");
    }
    // Conversion to RMS normalisation: a Z_unit = (a / factor) Z_rms.
    if (ZernikeNorm(norm) == ZernikeNorm::unit) mode.waves /= zernike_rms_factor(mode.j);
    modes.push_back(mode);
  });
  if (auto done = reader.finish(); !done) return fail(done.error());
  return ModesSet{std::move(modes)};
}

Json Wire<ModesSet>::to_json(const ModesSet& set) {
  return {{"modes", ovws::to_json(set.modes)}, {"norm", "rms"}};
}

Json Wire<Masks>::schema(SchemaParts& parts, const FieldInfo&) {
  const Json mask = detail::schema_reference<MaskConfig>(parts);
  return {
      {"anyOf",
       {mask, {{"type", "array"}, {"items", mask}, {"maxItems", kMaxMasks}}, {{"type", "null"}}}}};
}

Json Wire<ModesSet>::schema(SchemaParts&, const FieldInfo&) {
  const auto integer = [](int min, int max, const char* meaning) -> Json {
    return {{"type", "integer"}, {"minimum", min}, {"maximum", max}, {"description", meaning}};
  };
  const Json waves{{"type", "number"},
                   {"minimum", limits::kModeWaves.min},
                   {"maximum", limits::kModeWaves.max},
                   {"description",
                    "coefficient in the normalisation given by norm, waves at the laser's "
                    "wavelength"}};
  const int highest = zernike_index(kMaxZernikeIndex).n;
  const Json by_index{
      {"title", "ModeByJ"},
      {"type", "object"},
      {"properties", {{"j", integer(0, kMaxZernikeIndex, kModeIndexMeaning)}, {"waves", waves}}},
      {"required", {"j", "waves"}},
      {"additionalProperties", false}};
  const Json by_orders{
      {"title", "ModeByOrders"},
      {"type", "object"},
      {"properties",
       {{"n", integer(0, highest, "radial order")},
        {"m",
         integer(-highest, highest, "azimuthal frequency, |m| <= n, n - |m| even; negative: sine")},
        {"waves", waves}}},
      {"required", {"n", "m", "waves"}},
      {"additionalProperties", false}};
  return {{"title", "ModesSet"},
          {"type", "object"},
          {"properties",
           {{"modes",
             {{"type", "array"},
              {"items", {{"oneOf", {by_index, by_orders}}}},
              {"maxItems", kMaxZernikeIndex + 1},
              {"description", "modes, each given by j, or by n and m"}}},
            {"norm",
             {{"type", "string"},
              {"enum", kNames<ZernikeNorm>()},
              {"default", "rms"},
              {"description", "rms: RMS 1 over the pupil; unit: amplitude 1 at its edge"}}}}},
          {"required", {"modes"}},
          {"additionalProperties", false}};
}

}  // namespace ovws
