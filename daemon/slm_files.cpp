#include "daemon/slm_files.hpp"

#include <spdlog/fmt/fmt.h>

#include <cmath>
#include <fstream>
#include <opencv2/imgcodecs.hpp>
#include <optional>
#include <sstream>
#include <vector>

namespace ovws {
namespace {

/// All numbers of a text file; none if it cannot be read. `bad` is set to the first word that is
/// not a number.
std::optional<std::vector<double>> read_numbers(const std::string& path, std::string& bad) {
  std::ifstream file(path);
  if (!file) return std::nullopt;
  std::vector<double> numbers;
  for (std::string line; std::getline(file, line);) {
    line = line.substr(0, line.find('#'));
    for (char& c : line) c = (c == ',' || c == ';') ? ' ' : c;
    std::istringstream words(line);
    for (std::string word; words >> word;) {
      std::size_t used = 0;
      double value = NAN;
      try {
        value = std::stod(word, &used);
      } catch (const std::exception&) {
        used = 0;
      }
      if (used != word.size() || !std::isfinite(value)) {
        bad = word;
        return numbers;
      }
      numbers.push_back(value);
    }
  }
  return numbers;
}

Result<std::vector<double>> checked_numbers(const std::string& path, const char* field,
                                            std::size_t count) {
  std::string bad;
  const auto numbers = read_numbers(path, bad);
  if (!numbers) return fail(Errc::invalid, field, "the file " + path + " cannot be read");
  if (!bad.empty()) {
    return fail(Errc::invalid, field, fmt::format("{}: \"{}\" is not a number", path, bad));
  }
  if (numbers->size() != count) {
    return fail(Errc::invalid, field,
                fmt::format("{} holds {} numbers, not {}", path, numbers->size(), count));
  }
  return *numbers;
}

/// Empty if it cannot be read: OpenCV throws at a header that asks for too much.
cv::Mat read_picture(const std::string& path) {
  try {
    return cv::imread(path, cv::IMREAD_UNCHANGED);
  } catch (const cv::Exception&) {
    return {};
  }
}

Result<std::shared_ptr<const Image<float>>> flatness_from_png(const std::string& path, int width,
                                                              int height) {
  const cv::Mat grey = read_picture(path);
  if (grey.empty()) {
    return fail(Errc::invalid, "slm.flatness", "the picture " + path + " cannot be read");
  }
  if (grey.type() != CV_16UC1 || grey.cols != width || grey.rows != height) {
    return fail(
        Errc::invalid, "slm.flatness",
        fmt::format("{} is not a 16-bit grey picture of {} x {} pixels", path, width, height));
  }
  auto waves = std::make_shared<Image<float>>(width, height);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      waves->at(x, y) = float(grey.at<std::uint16_t>(y, x)) / 65536.0F;
    }
  }
  return waves;
}

}  // namespace

Result<PhaseLut> load_lut(const std::string& path) {
  const auto numbers = checked_numbers(path, "slm.lut", std::tuple_size_v<PhaseLut>);
  if (!numbers) return fail(numbers.error());
  PhaseLut lut{};
  for (std::size_t i = 0; i < lut.size(); ++i) {
    const double grey = (*numbers)[i];
    if (grey < 0.0 || grey > 255.0 || grey != std::floor(grey)) {
      return fail(Errc::invalid, "slm.lut",
                  fmt::format("{}: entry {} is {}, not a grey level from 0 to 255", path, i, grey));
    }
    lut[i] = std::uint8_t(grey);
  }
  return lut;
}

Result<std::shared_ptr<const Image<float>>> load_flatness(const std::string& path, int width,
                                                          int height) {
  if (path.ends_with(".png") || path.ends_with(".PNG")) {
    return flatness_from_png(path, width, height);
  }
  const auto numbers =
      checked_numbers(path, "slm.flatness", std::size_t(width) * std::size_t(height));
  if (!numbers) return fail(numbers.error());
  auto waves = std::make_shared<Image<float>>(width, height);
  std::copy(numbers->begin(), numbers->end(), waves->pixels.begin());
  return waves;
}

Result<HologramConfig> load_hologram_config(const Config& config) {
  HologramConfig hologram;
  hologram.slm = config.slm.geometry;
  hologram.sensor = config.sensor;
  if (config.slm.lut) {
    auto lut = load_lut(*config.slm.lut);
    if (!lut) return fail(lut.error());
    hologram.lut = *lut;
  }
  if (config.slm.flatness) {
    auto flatness =
        load_flatness(*config.slm.flatness, hologram.slm.width_px, hologram.slm.height_px);
    if (!flatness) return fail(flatness.error());
    hologram.flatness_waves = *flatness;
  }
  return hologram;
}

}  // namespace ovws
