#include "daemon/ovws/cli/watch_table.hpp"

#include <algorithm>
#include <cmath>

#include "core/optics/zernike.hpp"
#include "daemon/ovws/cli/commands.hpp"
#include "daemon/shared/client.hpp"

namespace ovws::cli {
namespace {

using nlohmann::json;

constexpr int kBarHalfWidth = 20;

/// A text bar that grows from the middle; each half spans `full_scale` waves.
std::string signed_bar(double waves, double full_scale) {
  const int length =
      std::min(kBarHalfWidth, int(std::abs(waves) / full_scale * kBarHalfWidth + 0.5));
  std::string left(std::size_t(kBarHalfWidth), ' ');
  std::string right = left;
  for (int i = 0; i < length; ++i) {
    (waves < 0 ? left[std::size_t(kBarHalfWidth - 1 - i)] : right[std::size_t(i)]) = '#';
  }
  return left + "|" + right;
}

std::size_t longest_name(const json& modes_j) {
  std::size_t length = 0;
  for (const json& j : modes_j) length = std::max(length, zernike_name(j.get<int>()).size());
  return length;
}

/// Prints one line per mode, with its standard error if the message has them. Returns the full
/// scale of the bars, waves.
double print_modes(const json& message) {
  double full_scale = 0.1;
  for (const json& value : message.at("coefficients")) {
    full_scale = std::max(full_scale, std::abs(value.get<double>()));
  }
  const std::size_t name_width = longest_name(message.at("j"));
  const json sigma = message.value("sigma", json::array());
  const bool has_errors = !sigma.empty() && sigma.front().is_number();
  for (std::size_t i = 0; i < message.at("j").size(); ++i) {
    const int j = message.at("j").at(i).get<int>();
    const double waves = message.at("coefficients").at(i).get<double>();
    const std::string bar = signed_bar(waves, full_scale);
    if (has_errors) {
      print("{:>3} {:<{}} {:+10.5f} +-{:.5f} {}\n", j, zernike_name(j), name_width, waves,
            sigma.at(i).get<double>(), bar);
    } else {
      print("{:>3} {:<{}} {:+9.4f} {}\n", j, zernike_name(j), name_width, waves, bar);
    }
  }
  return full_scale;
}

}  // namespace

bool has_table(const std::string& topic) {
  return topic == "wavefront" || topic == "refined";
}

void print_wavefront(const json& message, const json& status) {
  const bool valid = message.at("valid").get<bool>();
  print(
      "frame {}  hologram {}  charge {} ({})  spots {}/{}  saturated {:.0f} %  latency {:.0f} us  "
      "{}\n",
      message.at("frame_id").get<std::uint64_t>(), message.at("hologram_id").get<std::uint64_t>(),
      message.at("charge").get<int>(), message.at("tracker").get<std::string>(),
      message.at("tracked").get<int>(), message.at("subapertures").get<int>(),
      100.0 * message.at("saturated").get<double>(), message.at("latency_us").get<double>(),
      valid ? "valid" : "NOT VALID: " + why_not_valid(message, status));
  if (!valid) return;
  const double full_scale = print_modes(message);
  print("RMS {:.4f} wave without tilts, fit residual {:.4f} px, full bar {:.2f} wave\n",
        message.at("rms_waves").get<double>(), message.at("fit_residual_px").get<double>(),
        full_scale);
}

void print_refined(const json& message) {
  const bool valid = message.at("valid").get<bool>();
  const double age_s = 1e-9 * double(message.at("t_publish_ns").get<std::int64_t>() -
                                     message.at("t_arrival_ns").get<std::int64_t>());
  print("frame {}  hologram {}  charge {}  relative to the {}  {:.1f} s after its frame  {}\n",
        message.at("frame_id").get<std::uint64_t>(), message.at("hologram_id").get<std::uint64_t>(),
        message.at("charge").get<int>(), message.at("against").get<std::string>(), age_s,
        valid ? "valid" : "NOT VALID: " + message.at("reason").get<std::string>());
  if (!valid) return;
  const double full_scale = print_modes(message);
  print(
      "RMS {:.5f} wave without tilts, chi2 per pixel {:.2f}, peak {:.0f} electrons, {} iterations "
      "in {:.0f} ms, full bar {:.2f} wave\n",
      message.at("rms_waves").get<double>(), message.at("chi2_per_pixel").get<double>(),
      message.at("peak_e").get<double>(), message.at("iterations").get<int>(),
      message.at("duration_ms").get<double>(), full_scale);
}

}  // namespace ovws::cli
