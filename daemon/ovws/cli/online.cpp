/// ovws status and describe: what a daemon is and does.
#include <algorithm>
#include <nlohmann/json.hpp>

#include "daemon/ovws/cli/command_line.hpp"
#include "daemon/ovws/cli/commands.hpp"
#include "daemon/ovws/text/description.hpp"
#include "daemon/ovws/text/status.hpp"
#include "daemon/shared/client.hpp"
#include "proto/reader.hpp"

namespace ovws::cli {
namespace {

using nlohmann::json;

constexpr std::size_t kStatusColumn = 11;

BenchState state_of_bench(const Common& common, const json& status) {
  BenchState bench{status, {}, {}, {}, {}, {}, {}};
  for (const auto& [method, part] : {std::pair{"loop.get", &bench.loop},
                                     {"aberration.get", &bench.aberration},
                                     {"correction.get", &bench.correction},
                                     {"reference.get", &bench.reference}}) {
    *part = needed(call(common, method, json::object()));
  }
  bench.wavefront = needed(newest_wavefront(common));
  if (bench.wavefront.is_object() && !bench.wavefront.at("valid").get<bool>()) {
    bench.not_valid = why_not_valid(bench.wavefront, status);
  }
  return bench;
}

int show_status(const Common& common, const NoOptions&) {
  const json status = needed(call(common, "system.status", json::object()));
  if (common.json) return print_result(common, status, "");
  return print_result(common, status, status_text(state_of_bench(common, status)), kStatusColumn);
}

int describe(const Common& common, const std::string& name) {
  const json description = needed(call(common, "system.describe", json::object()));
  if (!name.empty() && entry_of(description, name).is_null()) {
    const auto near = nearest_name(name, entry_names(description));
    return report_mistake(common, {Errc::invalid, name,
                                   "no method or stream has this name" +
                                       (near ? "; did you mean " + *near + "?" : "")});
  }
  const std::string text = name.empty() ? list_text(description) : entry_text(description, name);
  return print_result(common, name.empty() ? description : entry_of(description, name), text,
                      kDescriptionColumn);
}

}  // namespace

void add_online_commands(CLI::App& app, const Common& common, int& status) {
  add_command(app, common, status, "status",
              "show the state of the bench: camera, SLM, reference, wavefront, loop, recording",
              show_status);
  auto [command, name] = add_command(
      app, common, status, "describe",
      "list every method and stream of the daemon, or explain one: its keys with ranges, and "
      "examples (with --json: their schemas)",
      describe);
  command.add_option("name", name, "method or stream, e.g. camera.set");
}

}  // namespace ovws::cli
