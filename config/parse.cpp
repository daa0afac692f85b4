/// Parses and validates the configuration file.
#include <algorithm>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <system_error>
#include <utility>

#include "config/tables.hpp"
#include "proto/reader.hpp"
#include "proto/strict_json.hpp"

namespace ovws {
namespace {

constexpr int kMaxDepth = 16;

Result<Config> read_config(const nlohmann::json& json) {
  Config config;
  ObjectReader reader(json, "");
  detail::decode_fields(reader, config);
  config.refine.format = config.camera.settings.pixel_format;
  if (!reader.failed()) {
    if (auto whole = check_refine(config.refine); !whole) {
      reader.fault("refine." + whole.error().field, whole.error().reason);
    }
  }
  if (auto done = reader.finish(); !done) return fail(done.error());
  use_modulator(config);
  return config;
}

constexpr std::string_view kIpc = "ipc://";

/// Relative paths start from `folder`; an empty path stays empty.
void resolve(std::string& path, const std::filesystem::path& folder) {
  if (!path.empty()) path = (folder / path).string();
}

Result<void> resolve_endpoint(std::string& endpoint, const std::filesystem::path& folder,
                              const char* field) {
  if (!endpoint.starts_with(kIpc) || endpoint.starts_with("ipc://@")) return {};
  std::string path = endpoint.substr(kIpc.size());
  resolve(path, folder);
  endpoint = std::string(kIpc) + path;
  if (auto fault = bind_fault(endpoint)) return fail(Errc::invalid, field, *fault);
  return {};
}

/// Makes every path of the configuration absolute. Relative ones start from the folder of its file,
/// so that they mean the same for a service, which runs in "/".
Result<void> resolve_paths(Config& config, const std::filesystem::path& folder) {
  for (auto* path : {&config.slm.lut, &config.slm.flatness, &config.security.secret_key,
                     &config.security.clients, &config.state.directory, &config.record.directory}) {
    if (*path) resolve(**path, folder);
  }
  for (MaskConfig& mask : config.sensor.masks) {
    if (mask.file) resolve(*mask.file, folder);
  }
  if (config.camera.driver == kReplayDriver) resolve(config.camera.id, folder);
  const std::pair<const char*, std::string*> endpoints[]{
      {"stream.endpoint", &config.stream.endpoint},
      {"stream.image_endpoint", &config.stream.image_endpoint},
      {"control.endpoint", &config.control.endpoint}};
  for (const auto& [field, endpoint] : endpoints) {
    if (auto done = resolve_endpoint(*endpoint, folder, field); !done) return done;
  }
  return {};
}

}  // namespace

std::optional<std::string> is_no_beam_name(const std::string& name) {
  constexpr std::size_t kLongest = 16;
  const bool plain = std::all_of(name.begin(), name.end(), [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || c == '-' || c == '_';
  });
  if (!name.empty() && name.size() <= kLongest && plain && name != kMainBeam) return std::nullopt;
  return "must have 1 to 16 lower-case letters, digits, - or _, and not be \"main\"";
}

/// Checks that the model can render the spots of a fixed array.
void check_array(const Config& config, ObjectReader& reader) {
  if (config.array.shape && !fits_into(config.sensor.grid, *config.array.shape)) {
    reader.fault("array.shape",
                 "lenslets of this shape overlap in the grid of sensor.grid: set "
                 "null, \"circle\", or the other grid");
  }
  if (config.optics.registered && !is_right_angled(*config.optics.registered)) {
    reader.fault("optics.px_per_cycle",
                 "of an array of lenslets, only mirrored images and turns by 90 degrees are "
                 "modelled, with equal scales along x and y: set null, or the nearest of these; "
                 "registration.run finds how far the array is turned");
  }
}

/// Endpoint rule: all endpoints must differ. The check is here so that the error can name the key.
void Rules<Config>::check(const Config& config, ObjectReader& reader) {
  for (std::size_t k = 0; k < config.beams.size(); ++k) {
    const auto same = [&](const BeamConfig& other) { return other.name == config.beams[k].name; };
    if (std::none_of(config.beams.begin(), config.beams.begin() + std::ptrdiff_t(k), same))
      continue;
    reader.fault("beams[" + std::to_string(k) + "].name", "must differ from the other names");
  }
  if (config.modulator == Modulator::fixed) check_array(config, reader);
  if (config.stream.endpoint == config.stream.image_endpoint) {
    reader.fault("stream.image_endpoint", "must differ from stream.endpoint");
  }
  if (config.control.endpoint == config.stream.endpoint ||
      config.control.endpoint == config.stream.image_endpoint) {
    reader.fault("control.endpoint", "must differ from the endpoints of stream");
  }
}

Result<Config> parse_config(const std::string& json_text) {
  const auto json = parse_strict_json(json_text, kMaxDepth, JsonComments::allowed);
  if (!json) return fail(Errc::invalid, "", json.error().reason);
  return read_config(*json);
}

Result<Config> load_config(const std::string& path) {
  const auto text = read_small_file(path);
  if (!text) return fail(Errc::unavailable, "", path + ": " + text.error().reason);
  auto config = parse_config(*text);
  std::error_code unknown;
  const auto folder = std::filesystem::absolute(path, unknown).parent_path();
  const auto resolved = config ? resolve_paths(*config, folder) : Result<void>{};
  if (config && resolved) return config;
  Error error = config ? resolved.error() : config.error();
  error.reason = path + ": " + error.reason;
  return fail(std::move(error));
}

}  // namespace ovws
