#include "daemon/examine/check/report.hpp"

#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/optics/zernike.hpp"
#include "daemon/examine/check/measured.hpp"

namespace ovws::examine {
namespace {

using nlohmann::json;
using study::number_or_null;

json finding_json(const Finding& one) {
  return {{"name", one.name},
          {"title", one.title},
          {"verdict", names_of(one.severity).name},
          {"text", one.text},
          {"limit", one.limit},
          {"fix", text_or_null(one.fix)},
          {"cost_waves", number_or_null(one.cost_waves)},
          {"cause", text_or_null(one.cause)}};
}

json response_json(const Response& response) {
  json modes = json::array();
  for (const Poke& poke : response.pokes) {
    json gains = json::array(), errors = json::array();
    for (const study::Mean& gain : poke.gain) {
      gains.push_back(number_or_null(gain.value));
      errors.push_back(number_or_null(gain.standard_error));
    }
    const study::Mean slope = slope_of(poke, response.modes_j);
    modes.push_back({{"j", poke.j},
                     {"name", zernike_name(poke.j)},
                     {"read", poke.read},
                     {"slope", number_or_null(slope.value)},
                     {"standard_error", number_or_null(slope.standard_error)},
                     {"crosstalk", number_or_null(crosstalk_of(poke, response.modes_j))},
                     {"error_waves", number_or_null(error_waves(poke, response.modes_j))},
                     {"gains", std::move(gains)},
                     {"gain_standard_errors", std::move(errors)}});
  }
  return {{"poke_waves", kPokeWaves}, {"modes_j", response.modes_j}, {"modes", std::move(modes)}};
}

json stability_json(const Record& record) {
  const Stability all = stability_of(record);
  json modes = json::array();
  for (const ModeStability& mode : all.modes) {
    modes.push_back({{"j", mode.j},
                     {"mean_waves", number_or_null(mode.mean)},
                     {"noise_waves", number_or_null(mode.noise)},
                     {"stated_waves", number_or_null(mode.stated)},
                     {"spread_waves", number_or_null(mode.spread)},
                     {"drift_waves", number_or_null(mode.drift)}});
  }
  return {{"seconds", record.seconds()},
          {"frames", record.frames.size()},
          {"frame_rate_hz", number_or_null(all.frame_rate_hz)},
          {"noise_waves", number_or_null(all.noise)},
          {"stated_waves", number_or_null(all.stated)},
          {"motion_waves", number_or_null(all.motion)},
          {"vibration_hz", all.frequency_hz > 0.0 ? json(all.frequency_hz) : json()},
          {"drift_waves", number_or_null(all.drift)},
          {"modes", std::move(modes)}};
}

}  // namespace

std::string cost_text(const Finding& one) {
  return std::isnan(one.cost_waves) ? "cost not known"
                                    : fmt::format("costs {:.4f} wave", one.cost_waves);
}

json report_json(const Measured& measured, const Findings& findings) {
  json all = json::array(), first = json::array();
  for (const Finding& one : findings) all.push_back(finding_json(one));
  for (const Finding& one : improve_first(findings)) first.push_back(one.name);
  json loop = json();
  if (!measured.loop.loop.is_null()) {
    loop = {{"rms_waves", number_or_null(rms_waves(measured.loop.record))},
            {"step", measured.loop.loop.at("step")}};
  }
  return {{"schema", "ovws.check/1"},
          {"version", measured.version},
          {"t_ns", measured.t_ns},
          {"quick", measured.quick},
          {"verdict", names_of(worst(findings)).name},
          {"improve_first", std::move(first)},
          {"findings", std::move(all)},
          {"response", response_json(measured.response)},
          {"stability", stability_json(measured.open)},
          {"settle", measured.settle.result},
          {"loop", std::move(loop)}};
}

std::string report_text(const Findings& findings) {
  const Findings first = improve_first(findings);
  std::string text;
  if (first.empty()) text += "nothing to improve\n";
  if (!first.empty()) text += "what to improve first:\n";
  for (std::size_t i = 0; i < first.size(); ++i) {
    text += fmt::format("{}. {} ({}): {}\n   {}\n", i + 1, first[i].title, cost_text(first[i]),
                        first[i].text, first[i].fix);
  }
  text += "\n";
  for (const Finding& one : findings) {
    text += fmt::format("{:<8} {:<13} {}\n", names_of(one.severity).name, one.name, one.text);
  }
  return text + fmt::format("verdict: {}", names_of(worst(findings)).name);
}

}  // namespace ovws::examine
