#include "daemon/web/commands.hpp"

#include <algorithm>
#include <array>

#include "proto/json_text.hpp"
#include "proto/strict_json.hpp"

namespace ovws::web {
namespace {

using nlohmann::json;

constexpr int kMaxDepth = 16;
constexpr std::array<std::string_view, 18> kMethods{
    "aberration.clear", "aberration.set",  "camera.set",    "correction.clear", "job.cancel",
    "job.get",          "loop.close",      "loop.get",      "loop.open",        "record.start",
    "record.stop",      "reference.clear", "reference.get", "reference.set",    "reference.take",
    "sensor.set",       "slm.show",        "slm.verify"};

}  // namespace

tl::expected<Command, Refusal> parse_command(const std::string& body) {
  const auto request = parse_strict_json(body, kMaxDepth, JsonComments::refused);
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

std::string carry_out(const cli::Common& common, const Command& command) {
  const auto result = cli::call(common, command.method, command.params);
  const json reply = result ? json{{"result", *result}} : json{{"error", result.error().error}};
  return json_text(reply);
}

}  // namespace ovws::web
