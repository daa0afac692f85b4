#include "daemon/web/commands.hpp"

#include <algorithm>
#include <array>

#include "proto/json_text.hpp"
#include "proto/strict_json.hpp"

namespace ovws::web {
namespace {

using nlohmann::json;

constexpr int kMaxCommandDepth = 16;
constexpr auto kMethods =
    std::to_array<std::string_view>({"aberration.clear", "aberration.set",   "calibration.clear",
                                     "calibration.get",  "calibration.run",  "camera.auto_exposure",
                                     "camera.set",       "config.save",      "correction.clear",
                                     "flatness.clear",   "flatness.run",     "job.cancel",
                                     "job.get",          "loop.close",       "loop.get",
                                     "loop.identify",    "loop.model",       "loop.open",
                                     "lut.clear",        "lut.run",          "record.estimate",
                                     "record.list",      "record.start",     "record.stop",
                                     "reference.clear",  "reference.delete", "reference.get",
                                     "reference.list",   "reference.load",   "reference.save",
                                     "reference.set",    "reference.take",   "registration.clear",
                                     "registration.run", "sensor.set",       "slm.set",
                                     "slm.settle",       "slm.show",         "slm.verify",
                                     "system.describe"});

}  // namespace

tl::expected<Command, Refusal> parse_command(const std::string& body) {
  const auto request = parse_strict_json(body, kMaxCommandDepth, JsonComments::refused);
  if (!request || !request->is_object()) return tl::make_unexpected(Refusal::malformed);
  const json method = request->value("method", json());
  const json params = request->value("params", json::object());
  if (!method.is_string() || !params.is_object()) return tl::make_unexpected(Refusal::malformed);
  Command command{method.get<std::string>(), params};
  if (std::find(kMethods.begin(), kMethods.end(), command.method) == kMethods.end()) {
    return tl::make_unexpected(Refusal::command);
  }
  return command;
}

bool changes_bench(const Command& command) {
  const auto ends = {".get", ".list", ".model", ".estimate", ".describe", ".verify"};
  return std::none_of(ends.begin(), ends.end(),
                      [&](const char* end) { return command.method.ends_with(end); });
}

std::string carry_out(const cli::Common& common, const Command& command) {
  const auto result = cli::call(common, command.method, command.params);
  const json reply = result ? json{{"result", *result}} : json{{"error", result.error().error}};
  return json_text(reply);
}

}  // namespace ovws::web
