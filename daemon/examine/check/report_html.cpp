#include <spdlog/fmt/chrono.h>
#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <ctime>

#include "core/optics/zernike.hpp"
#include "daemon/examine/check/measured.hpp"
#include "daemon/examine/check/report.hpp"

namespace ovws::examine {
namespace {

using nlohmann::json;

constexpr const char* kStyle = R"(
:root { color-scheme: light; }
body { font: 15px/1.45 sans-serif; color: #1b1f24; background: #fff; max-width: 62rem;
       margin: 2rem auto; padding: 0 1rem; }
h1 { font-size: 1.6rem; margin-bottom: 0.2rem; } h2 { font-size: 1.2rem; margin-top: 2rem; }
.facts { color: #454c54; margin: 0; }
table { border-collapse: collapse; width: 100%; } caption { text-align: left; }
th, td { text-align: left; vertical-align: top; padding: 0.3rem 0.6rem 0.3rem 0;
         border-bottom: 1px solid #d8dde2; }
td.n, th.n { text-align: right; font-variant-numeric: tabular-nums; }
.verdict { font-weight: 600; padding: 0.05rem 0.5rem; border-radius: 0.6rem; white-space: nowrap;
           print-color-adjust: exact; -webkit-print-color-adjust: exact; }
.good { background: #d9f0de; color: #14532d; } .note { background: #dfe9f7; color: #1d3f72; }
.warning { background: #fdeec2; color: #6b4700; } .bad { background: #f9d6d5; color: #8a1411; }
code { background: #f1f3f5; padding: 0.1rem 0.3rem; overflow-wrap: anywhere; }
.limit { color: #454c54; font-size: 0.9em; }
figure { margin: 1.2rem 0; break-inside: avoid; } figcaption { color: #454c54; font-size: 0.9em; }
svg { width: 100%; height: auto; max-width: 48rem; display: block; }
svg.matrix { max-width: 36rem; print-color-adjust: exact; -webkit-print-color-adjust: exact; }
.wide { overflow-x: auto; } tr { break-inside: avoid; }
@media print { body { margin: 0; max-width: none; font-size: 11px; } }
)";

constexpr std::array<std::pair<char, std::string_view>, 4> kEscapes{
    {{'&', "&amp;"}, {'<', "&lt;"}, {'>', "&gt;"}, {'"', "&quot;"}}};

std::string escaped(std::string_view text) {
  std::string out;
  for (const char& c : text) {
    const auto escape = std::ranges::find(kEscapes, c, [](const auto& one) { return one.first; });
    out += escape == kEscapes.end() ? std::string_view(&c, 1) : escape->second;
  }
  return out;
}

std::string badge(Severity verdict) {
  return fmt::format("<span class=\"verdict {0}\">{0}</span>", names_of(verdict).name);
}

std::string local_time(std::int64_t t_ns) {
  const std::time_t seconds = t_ns / 1'000'000'000;
  return fmt::format("{:%Y-%m-%d %H:%M:%S %Z}", fmt::localtime(seconds));
}

std::string bench_lines(const Measured& measured) {
  const json& status = measured.status;
  const json &camera = status.at("camera"), &slm = status.at("slm").at("info");
  const json &settings = camera.at("settings"), &sensor = measured.sensor;
  const json& optics = measured.config.at("optics");
  std::string gain = "no gain in dB";
  if (settings.at("gain_db").is_number()) {
    gain = fmt::format("{:g} dB", settings.at("gain_db").get<double>());
  }
  return fmt::format(
      "<p class=\"facts\">{}, {:.0f} s of frames with the loop open, ovws {}{}</p>\n"
      "<p class=\"facts\">Camera {} {} (serial {}), exposure {:g} µs, {}, {:g} frames/s, {}</p>\n"
      "<p class=\"facts\">SLM {}, {} × {} pixels; {:g} nm, lens of {:g} mm</p>\n"
      "<p class=\"facts\">Sensor: charge {}, {} subapertures, {} modes, tracker {}, operator "
      "{}</p>\n",
      local_time(measured.t_ns), measured.open.seconds(), escaped(measured.version),
      measured.quick ? ", quick" : "", escaped(text_at(camera.at("info"), "/vendor")),
      escaped(text_at(camera.at("info"), "/model")), escaped(text_at(camera.at("info"), "/serial")),
      settings.at("exposure_us").get<double>(), gain, settings.at("frame_rate_hz").get<double>(),
      escaped(text_at(settings, "/pixel_format")), escaped(text_at(slm, "/output")),
      slm.at("width").get<int>(), slm.at("height").get<int>(),
      optics.at("wavelength_nm").get<double>(), optics.at("focal_length_mm").get<double>(),
      sensor.at("charge").get<int>(), sensor.at("subapertures").get<int>(),
      sensor.at("modes_j").size(), escaped(text_at(sensor, "/tracker")),
      escaped(text_at(sensor, "/operator_in_force")));
}

std::string improvements(const Findings& findings) {
  std::string html = "<h2>What to improve first</h2>\n";
  const Findings first = improve_first(findings);
  if (first.empty()) return html + "<p>Nothing: every check is good.</p>\n";
  html += "<ol>\n";
  for (const Finding& one : first) {
    html += fmt::format("<li>{} <strong>{}</strong> ({}): {}.<br><code>{}</code></li>\n",
                        badge(one.severity), escaped(one.title), cost_text(one), escaped(one.text),
                        escaped(one.fix));
  }
  return html + "</ol>\n";
}

std::string findings_table(const Findings& findings) {
  std::string html =
      "<h2>Findings</h2>\n<table>\n<thead><tr><th scope=\"col\">Severity</th><th "
      "scope=\"col\">Subject</th><th scope=\"col\">Result, and the limit of "
      "“good”</th></tr></thead>\n<tbody>\n";
  for (const Finding& one : findings) {
    html += fmt::format(
        "<tr><td>{}</td><td>{}</td><td>{}{}<div class=\"limit\">{}</div></td></tr>\n",
        badge(one.severity), escaped(one.title), escaped(one.text),
        one.cause.empty() ? "" : " (explained by: " + escaped(one.cause) + ")", escaped(one.limit));
  }
  return html + "</tbody>\n</table>\n";
}

std::string figures(const Measured& measured) {
  std::string html = "<h2>Figures</h2>\n";
  if (!measured.response.pokes.empty()) {
    html += "<figure>" + matrix_svg(measured.response) +
            "<figcaption>Response: columns are the modes shown, rows the modes read. Blue is "
            "positive, red negative. Full blue on the diagonal is 1; cross-talk is drawn ten times "
            "as strong.</figcaption></figure>\n";
  }
  for (const study::Figure& figure : figures_of(measured)) {
    const auto svg = study::svg_of(figure);
    if (!svg) {
      return html + "<p>There are no curves: " + escaped(text_of(svg.error())) + ".</p>\n";
    }
    html += "<figure>" + *svg + "</figure>\n";
  }
  return html;
}

std::string cell(double value, const char* format) {
  return std::isnan(value)
             ? "<td class=\"n\">–</td>"
             : "<td class=\"n\">" + fmt::format(fmt::runtime(format), value) + "</td>";
}

std::string mode_table(const Measured& measured) {
  const Response& response = measured.response;
  const Stability stability = stability_of(measured.open);
  std::string html =
      "<h2>Modes</h2>\n<div class=\"wide\"><table>\n<thead><tr><th class=\"n\" "
      "scope=\"col\">j</th><th scope=\"col\">Mode</th>";
  for (const char* head : {"Slope", "± 1 σ", "Cross-talk", "Error, wave", "Noise, wave",
                           "Stated, wave", "Spread, wave", "Drift, wave"}) {
    html += fmt::format("<th class=\"n\" scope=\"col\">{}</th>", head);
  }
  html += "</tr></thead>\n<tbody>\n";
  for (std::size_t k = 0; k < response.pokes.size(); ++k) {
    const Poke& poke = response.pokes[k];
    const study::Mean slope = slope_of(poke, response.modes_j);
    const double unknown = study::kUnknown;
    html += fmt::format("<tr><td class=\"n\">{}</td><td>{}</td>", poke.j, zernike_name(poke.j));
    html +=
        cell(slope.value, "{:.4f}") + cell(poke.read ? slope.standard_error : unknown, "{:.4f}");
    html += cell(poke.read ? crosstalk_of(poke, response.modes_j) : unknown, "{:.4f}");
    html += cell(poke.read ? error_waves(poke, response.modes_j) : unknown, "{:.4f}");
    const ModeStability mode = k < stability.modes.size() ? stability.modes[k] : ModeStability{};
    for (const double value : {mode.noise, mode.stated, mode.spread, mode.drift}) {
      html += cell(stability.usable ? value : unknown, "{:.5f}");
    }
    html += "</tr>\n";
  }
  return html + "</tbody>\n</table></div>\n";
}

}  // namespace

std::string report_html(const Measured& measured, const Findings& findings) {
  return fmt::format(
      "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n<meta "
      "name=\"viewport\" content=\"width=device-width\">\n<title>ovws check, "
      "{}</title>\n<style>{}</style>\n</head>\n<body>\n<main>\n<h1>Check of the bench "
      "{}</h1>\n{}{}{}{}{}</main>\n</body>\n</html>\n",
      local_time(measured.t_ns), kStyle, badge(worst(findings)), bench_lines(measured),
      improvements(findings), findings_table(findings), figures(measured), mode_table(measured));
}

}  // namespace ovws::examine
