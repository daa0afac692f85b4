#include "daemon/ovws/cli/experiment_images.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <opencv2/imgproc.hpp>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "core/wavefront/phase_map.hpp"
#include "daemon/ovws/cli/image_file.hpp"
#include "daemon/ovws/study/sensor.hpp"

namespace ovws::cli {
namespace {

using nlohmann::json;

constexpr int kPanelPx = 320, kTextPx = 52, kGapPx = 10;
constexpr double kResidualGainDb = 36.0;
const cv::Scalar kPaper(255, 255, 255), kInk(0, 0, 0);

/// Row of image panels, side by side. Each panel is below two lines of text.
class Row {
 public:
  void add(const cv::Mat& picture, const std::string& title, const std::string& more) {
    cv::Mat panel(kPanelPx + kTextPx, kPanelPx + kGapPx, CV_8UC3, kPaper);
    cv::Mat scaled;
    cv::resize(picture, scaled, {kPanelPx, kPanelPx}, 0, 0, cv::INTER_AREA);
    scaled.copyTo(panel(cv::Rect(0, kTextPx, kPanelPx, kPanelPx)));
    const auto write = [&panel](const std::string& text, int y) {
      cv::putText(panel, text, {4, y}, cv::FONT_HERSHEY_SIMPLEX, 0.5, kInk, 1, cv::LINE_AA);
    };
    write(title, 18);
    write(more, 40);
    if (all_.empty()) {
      all_ = panel;
    } else {
      cv::hconcat(all_, panel, all_);
    }
  }
  const cv::Mat& picture() const { return all_; }

 private:
  cv::Mat all_;
};

cv::Mat coloured(const Image<float>& waves, double scale) {
  return phase_colours(matrix_on(waves), scale, kPaper);
}

double largest(const Image<float>& waves) {
  double most = 1e-4;
  for (const float w : waves.pixels) most = std::fmax(most, std::abs(double(w)));
  return most;
}

/// Index of the frame with the median variance; none if no frame has coefficients.
std::optional<std::size_t> median_frame(const json& cell) {
  std::vector<std::pair<double, std::size_t>> valid_frames;
  const json& variances = cell.at("variances_rad2");
  for (std::size_t k = 0; k < variances.size(); ++k) {
    if (variances[k].is_number()) valid_frames.emplace_back(variances[k].get<double>(), k);
  }
  if (valid_frames.empty()) return std::nullopt;
  std::sort(valid_frames.begin(), valid_frames.end());
  return valid_frames[valid_frames.size() / 2].second;
}

std::size_t next_gain(const std::vector<double>& gains_db) {
  const auto off = [](double gain_db) { return std::abs(gain_db - kResidualGainDb); };
  return std::size_t(std::ranges::min_element(gains_db, {}, off) - gains_db.begin());
}

struct Residual {
  Image<float> waves;
  std::string text;
};

/// Residual wavefront of the cell's median frame; none if no frame has coefficients.
std::optional<Residual> residual_of(const json& cell, const PhaseMap& map,
                                    const std::vector<float>& introduced) {
  const auto frame = median_frame(cell);
  if (!frame) return std::nullopt;
  auto left = cell.at("coefficients_waves").at(*frame).get<std::vector<float>>();
  for (std::size_t i = 0; i < left.size(); ++i) left[i] = introduced[i] - left[i];
  Residual residual;
  map.render(left, residual.waves);
  residual.text =
      fmt::format("{:.3g} rad^2, +-{:.3f} wave", cell.at("variances_rad2").at(*frame).get<double>(),
                  largest(residual.waves));
  return residual;
}

}  // namespace

Result<void> draw_camera_frames(const CameraFrames& frames, const std::filesystem::path& folder) {
  std::map<int, Row> rows;
  for (const CameraFrame& one : frames) {
    const cv::Mat grey = matrix_on(one.image);
    cv::Mat picture;
    cv::cvtColor(grey, picture, cv::COLOR_GRAY2BGR);
    picture.setTo(cv::Scalar(60, 60, 255), grey == 255);
    rows[one.charge].add(picture, fmt::format("charge {}, {:g} dB", one.charge, one.gain_db),
                         fmt::format("brightest {:g} DN; red: full scale", one.peak_dn));
  }
  for (const auto& [charge, row] : rows) {
    auto written =
        write_image(folder / fmt::format("experiment-images-charge-{}.png", charge), row.picture());
    if (!written) return written;
  }
  return {};
}

Result<void> draw_residuals(const GainSweep& sweep, const study::SweepCells& cells,
                            const std::filesystem::path& folder) {
  const std::size_t aberration = std::min<std::size_t>(1, sweep.aberrations.size() - 1);
  const std::size_t arms = sweep.arms.size(), gain = next_gain(sweep.gains_db);
  const std::size_t first = (aberration * sweep.gains_db.size() + gain) * arms;
  Row row;
  for (std::size_t k = 0; k < arms; ++k) {
    const json& cell = cells.at(int(first + k));
    const auto modes_j = cell.at("modes_j").get<std::vector<int>>();
    const PhaseMap map(modes_j, kPanelPx);
    const auto introduced = study::waves_of(sweep.aberrations[aberration].modes, modes_j);
    const std::vector<float> waves(introduced.begin(), introduced.end());
    Image<float> shown;
    map.render(waves, shown);
    const double scale = largest(shown);  // one colour scale for all panels
    if (k == 0) {
      row.add(coloured(shown, scale), fmt::format("introduced, {:g} dB", sweep.gains_db[gain]),
              fmt::format("+-{:.3f} wave", scale));
    }
    const auto residual = residual_of(cell, map, waves);
    if (!residual) continue;
    row.add(coloured(residual->waves, scale), study::arm_name(sweep.arms[k]) + ", residual",
            residual->text);
  }
  return write_image(folder / "experiment-residual.png", row.picture());
}

}  // namespace ovws::cli
