#include "daemon/shared/slm_files.hpp"

#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <optional>
#include <span>
#include <sstream>
#include <string_view>
#include <vector>

#include "core/base/number_text.hpp"
#include "daemon/shared/encoding.hpp"
#include "drivers/png/grey_png.hpp"

namespace ovws {
namespace {

constexpr std::string_view kByteOrderMark = "\xEF\xBB\xBF";  // some editors begin UTF-8 with it

/// The numbers of a text file line by line, without lines that have none. Errors: the file cannot
/// be read; a word is not a finite number.
Result<std::vector<std::vector<double>>> lines_of(const std::string& path,
                                                  const std::string& field) {
  std::ifstream file(path);
  if (!file) return fail(Errc::invalid, field, "the file " + path + " cannot be read");
  std::vector<std::vector<double>> lines;
  for (std::string line; std::getline(file, line);) {
    if (lines.empty() && line.starts_with(kByteOrderMark)) line.erase(0, kByteOrderMark.size());
    line = line.substr(0, line.find('#'));
    for (char& c : line) c = (c == ',' || c == ';') ? ' ' : c;
    std::istringstream words(line);
    std::vector<double> numbers;
    for (std::string word; words >> word;) {
      const auto value = finite_number(word);
      if (!value) {
        return fail(Errc::invalid, field,
                    fmt::format("{}: \"{}\" is not a finite number", path, word));
      }
      numbers.push_back(*value);
    }
    if (!numbers.empty()) lines.push_back(std::move(numbers));
  }
  return lines;
}

/// Checks that the LUT is monotonic except for one phase wrap. More changes of direction mean a
/// damaged file.
Result<void> check_monotonic(const std::string& path, const PhaseLut& lut) {
  std::vector<std::size_t> rises, falls;
  for (std::size_t i = 1; i < lut.size(); ++i) {
    if (lut[i] > lut[i - 1]) rises.push_back(i);
    if (lut[i] < lut[i - 1]) falls.push_back(i);
  }
  const auto& wrong = rises.size() < falls.size() ? rises : falls;
  if (wrong.size() <= 1) return {};
  return fail(
      Errc::invalid, "slm.lut",
      fmt::format("{} is not monotonic: entry {} is {}, entry {} is {}; it has {} such changes of "
                  "direction, but only one phase wrap is allowed",
                  path, wrong[0] - 1, lut[wrong[0] - 1], wrong[0], lut[wrong[0]], wrong.size()));
}

bool is_png(const std::string& path) {
  return path.ends_with(".png") || path.ends_with(".PNG");
}

/// Phase map of a 16-bit PNG, waves: 65536 is one wave.
Result<Image<float>> waves_of(const Result<Image<std::uint16_t>>& grey, const std::string& field) {
  if (!grey) return fail(Errc::invalid, field, grey.error().reason);
  Image<float> waves(grey->width, grey->height);
  std::transform(grey->pixels.begin(), grey->pixels.end(), waves.pixels.begin(),
                 [](std::uint16_t level) { return float(level) / 65536.0F; });
  return waves;
}

/// Phase map of a text file with one row of numbers (waves) per line.
Result<Image<float>> waves_of_text(const std::string& path, const std::string& field) {
  const auto lines = lines_of(path, field);
  if (!lines) return fail(lines.error());
  const std::size_t cols = lines->empty() ? 0 : lines->front().size();
  const auto other = std::find_if(lines->begin(), lines->end(),
                                  [cols](const auto& l) { return l.size() != cols; });
  if (other != lines->end()) {
    return fail(Errc::invalid, field,
                fmt::format("{}: row {} has {} numbers, the first row {}", path,
                            other - lines->begin() + 1, other->size(), cols));
  }
  Image<float> waves(int(cols), int(lines->size()));
  for (int y = 0; y < waves.height; ++y) {
    std::copy((*lines)[std::size_t(y)].begin(), (*lines)[std::size_t(y)].end(), waves.row(y));
  }
  return waves;
}

}  // namespace

Result<PhaseLut> load_lut(const std::string& path) {
  const auto lines = lines_of(path, "slm.lut");
  if (!lines) return fail(lines.error());
  PhaseLut lut{};
  std::vector<double> numbers;
  for (const auto& line : *lines) numbers.insert(numbers.end(), line.begin(), line.end());
  if (numbers.size() != lut.size()) {
    return fail(Errc::invalid, "slm.lut",
                fmt::format("{} has {} numbers instead of {}", path, numbers.size(), lut.size()));
  }
  for (std::size_t i = 0; i < lut.size(); ++i) {
    const double grey = numbers[i];
    if (grey < 0.0 || grey > 255.0 || grey != std::floor(grey)) {
      return fail(Errc::invalid, "slm.lut",
                  fmt::format("{}: entry {} is {}, not a grey level from 0 to 255", path, i, grey));
    }
    lut[i] = std::uint8_t(grey);
  }
  if (auto monotonic = check_monotonic(path, lut); !monotonic) return fail(monotonic.error());
  return lut;
}

Result<std::shared_ptr<const Image<float>>> load_flatness(const std::string& path, int width,
                                                          int height) {
  constexpr const char* kField = "slm.flatness";
  auto waves = is_png(path) ? waves_of(read_grey16_png(path, width, height), kField)
                            : waves_of_text(path, kField);
  if (!waves) return fail(waves.error());
  if (waves->width != width || waves->height != height) {
    return fail(Errc::invalid, kField,
                fmt::format("{} is {} x {} pixels, the SLM {} x {}: they must be equal", path,
                            waves->width, waves->height, width, height));
  }
  return std::make_shared<const Image<float>>(std::move(*waves));
}

namespace {

Result<std::shared_ptr<const Image<float>>> load_map(const std::string& path,
                                                     const std::string& field) {
  auto waves = is_png(path) ? waves_of(read_grey16_png(path, kMaxMaskPx), field)
                            : waves_of_text(path, field);
  if (!waves) return fail(waves.error());
  return std::make_shared<const Image<float>>(std::move(*waves));
}

Result<void> use_map(MaskConfig& mask, std::shared_ptr<const Image<float>> map,
                     const std::string& field) {
  const std::string sha256 = sha256_of(std::span<const float>(map->pixels));
  if (!mask.sha256.empty() && mask.sha256 != sha256) {
    return fail(Errc::invalid, field,
                fmt::format("{} has another content than its sha256 says ({}): restore the file, "
                            "or remove the checksum",
                            *mask.file, sha256));
  }
  mask.sha256 = sha256;
  mask.map = std::move(map);
  return {};
}

}  // namespace

Result<void> load_masks(SensorConfig& sensor) {
  Masks& masks = sensor.masks;
  for (std::size_t k = 0; k < masks.size(); ++k) {
    if (!masks[k].file || masks[k].map) continue;
    const std::string field = mask_field(k, masks.size()) + ".file";
    const auto known = std::find_if(masks.begin(), masks.end(), [&](const MaskConfig& one) {
      return one.map && one.file == masks[k].file;
    });
    auto map = known != masks.end() ? known->map : load_map(*masks[k].file, field);
    if (!map) return fail(map.error());
    if (auto used = use_map(masks[k], std::move(*map), field); !used) return used;
    if (map_pixels(masks) > kMaxMaskPixels) break;
  }
  return check_masks(masks, kMaxSubapertures);
}

Result<Config> load_config_and_masks(const std::string& path) {
  auto config = path.empty() ? Result<Config>{Config{}} : load_config(path);
  if (!config) return config;
  if (auto read = load_masks(config->sensor); !read) return fail(read.error());
  return config;
}

Result<HologramConfig> load_hologram_config(const Config& config) {
  HologramConfig hologram;
  hologram.slm = config.slm.geometry;
  hologram.sensor = config.sensor;
  if (config.modulator == Modulator::dmd) hologram.dmd = config.dmd;
  if (auto read = load_masks(hologram.sensor); !read) return fail(read.error());
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
