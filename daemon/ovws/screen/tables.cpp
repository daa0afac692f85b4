/// Draws the tables of latencies, losses and events.
#include <fmt/core.h>

#include <algorithm>
#include <array>

#include "daemon/ovws/screen/page.hpp"
#include "daemon/ovws/text/fill.hpp"

namespace ovws::screen {
namespace {

using nlohmann::json;

constexpr int kNameWidth = 13;
constexpr std::array<int, 4> kNumberWidths{5, 5, 6, 5};

std::string words(std::string name) {
  std::replace(name.begin(), name.end(), '_', ' ');
  return name;
}

/// A time in at most five characters: microseconds without a unit, longer times with ms or s.
std::string short_us(double us) {
  if (us < 10e3) return fmt::format("{:.0f}", us);
  return us < 1e6 ? fmt::format("{:.0f}ms", us / 1e3) : fmt::format("{:.0f}s", us / 1e6);
}

Style style_of(const std::string& severity) {
  if (severity == "error") return Style::alarm;
  return severity == "warning" ? Style::negative : Style::normal;
}

}  // namespace

void draw_latency(Canvas& canvas, Rect rect, const View& view) {
  const auto row = [&](int y, const std::string& name, Style style,
                       const std::array<std::string, 4>& numbers) {
    canvas.text(rect.x, y, kNameWidth, name, style);
    int x = rect.x + kNameWidth;
    for (std::size_t k = 0; k < numbers.size(); ++k) {
      x += canvas.text(x, y, rect.x + rect.width - x,
                       fmt::format("{:>{}}", numbers[k], kNumberWidths[k]), style);
    }
  };
  row(rect.y, "latency, µs", Style::title, {"p50", "p99", "p99.9", "max"});
  if (view.status.is_null()) return;
  int y = rect.y;
  for (const char* stage : {"arrived", "tracked", "reconstructed", "published"}) {
    const json& all = view.status.at("latency");
    if (!all.contains(stage) || ++y >= rect.y + rect.height) continue;
    const json& one = all.at(stage);
    const auto number = [&](const char* key) {
      const bool counted = one.at("count").get<std::uint64_t>() > 0;
      return counted ? short_us(one.at(key).get<double>()) : std::string("-");
    };
    row(y, stage, Style::normal,
        {number("p50_us"), number("p99_us"), number("p999_us"), number("max_us")});
  }
}

void draw_losses(Canvas& canvas, Rect rect, const View& view) {
  canvas.text(rect.x, rect.y, rect.width, "losses, since the start", Style::title);
  if (view.status.is_null()) return;
  if (view.losses.empty()) canvas.text(rect.x, rect.y + 1, rect.width, "none", Style::dim);
  const int rows = rect.height - 1;
  for (int k = 0; k < std::min(rows, int(view.losses.size())); ++k) {
    const Loss& loss = view.losses[std::size_t(k)];
    const int hidden = int(view.losses.size()) - rows;
    if (k == rows - 1 && hidden > 0) {
      canvas.text(rect.x, rect.y + rows, rect.width, fmt::format("and {} more", hidden + 1),
                  Style::dim);
      return;
    }
    const std::string grown = loss.grown > 0 ? fmt::format("  +{}", loss.grown) : "";
    canvas.text(rect.x, rect.y + 1 + k, rect.width,
                fmt::format("{:<20}{:>8}{}", words(loss.name), loss.count, grown),
                loss.grown > 0 ? Style::negative : Style::normal);
  }
}

void draw_events(Canvas& canvas, Rect rect, const View& view) {
  canvas.text(rect.x, rect.y, rect.width, "events", Style::title);
  const int rows = std::min(rect.height - 1, int(view.events.size()));
  for (int k = 0; k < rows; ++k) {
    const json& event = view.events[view.events.size() - std::size_t(rows) + std::size_t(k)];
    canvas.text(rect.x, rect.y + 1 + k, rect.width,
                cli::fill("{t_ns:clock}  [!severity=info?{severity}: ]{text}", event),
                style_of(event.at("severity").get<std::string>()));
  }
}

}  // namespace ovws::screen
