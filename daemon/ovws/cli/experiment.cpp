/// ovws study experiment: the paper's gain sweep on a daemon's bench.
#include <fmt/core.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <csignal>
#include <fstream>
#include <map>
#include <opencv2/imgproc.hpp>
#include <optional>
#include <thread>
#include <vector>

#include "core/wavefront/phase_map.hpp"
#include "daemon/ovws/cli/commands.hpp"
#include "daemon/ovws/cli/image_file.hpp"
#include "daemon/ovws/cli/study_files.hpp"
#include "daemon/ovws/study/gain_sweep_report.hpp"
#include "daemon/ovws/study/parallel.hpp"
#include "daemon/shared/client.hpp"
#include "daemon/shared/encoding.hpp"
#include "proto/json_text.hpp"

namespace ovws::cli {
namespace {

using namespace std::chrono_literals;
using nlohmann::json;

constexpr auto kCellPollInterval = 300ms;
constexpr int kStartTries = 10;  // a cancelled job may still be ending
constexpr int kRefusedCode = -32000;

/// Results of experiment.cell by number.
using SweepCells = std::map<int, json>;

volatile std::sig_atomic_t stop_asked = 0;

void note_interrupt(int) {
  stop_asked = 1;
}

using Answer = tl::expected<json, CallFailure>;

Answer start(const Common& common, const json& params) {
  for (int tries = 1;; ++tries) {
    Answer answer = call(common, "experiment.gain_sweep", params);
    const bool busy =
        !answer && answer.error().answered && answer.error().error.value("code", 0) == kRefusedCode;
    if (!busy || tries == kStartTries || stop_asked != 0) return answer;
    std::this_thread::sleep_for(kCellPollInterval);
  }
}

tl::unexpected<Error> no_csv() {
  return fail(Errc::unavailable, "output", "a CSV file cannot be written");
}

/// Cells fetched from one run of the gain sweep. Each cell is written to both CSV files as soon as
/// it is fetched.
class Fetched {
 public:
  Fetched(int job, std::filesystem::path folder) : job_(job), folder_(std::move(folder)) {}
  int job() const { return job_; }
  /// Whether a result of experiment.get belongs to this job's run. The daemon may hold the results
  /// of another run.
  bool is_own(const json& experiment) {
    if (experiment.at("job") == job_) run_ = experiment.at("run");
    return !run_.is_null() && experiment.at("run") == run_;
  }
  void set_run(const json& name) { run_ = name; }
  /// Whether the cell is already fetched: same number, same start time.
  bool has(const json& summary) const {
    const auto found = cells_.find(summary.at("cell").get<int>());
    return found != cells_.end() && is_same(found->second, summary);
  }
  static bool is_same(const json& cell, const json& summary) {
    return cell.at("cell") == summary.at("cell") &&
           cell.at("t_begun_ns") == summary.at("t_begun_ns");
  }
  /// Adds a cell to both CSV files. Only the first cell removes earlier results from the folder, so
  /// that a refused job leaves the results in place.
  Result<void> add(json cell) {
    if (cells_.empty()) {
      // Earlier results may come from another run: do not mix them with the new cells.
      if (auto removed = remove_findings("experiment", folder_); !removed) return removed;
      begin_files();
    }
    const bool written = write(cell);
    const int number = cell.at("cell").get<int>();
    cells_[number] = std::move(cell);
    if (!written) return no_csv();
    return {};
  }
  /// Rewrites both CSV files in the order of cell numbers. False if a file cannot be written.
  bool write_in_order() {
    begin_files();
    return std::all_of(cells_.begin(), cells_.end(),
                       [this](const auto& one) { return write(one.second); });
  }
  const SweepCells& cells() const { return cells_; }

 private:
  void begin_files() {
    cells_file_ = std::ofstream(folder_ / "cells.csv");
    frames_file_ = std::ofstream(folder_ / "frames.csv");
    cells_file_ << study::cells_csv_header() << std::flush;
  }
  bool write(const json& cell) {
    if (frames_file_.tellp() == 0) frames_file_ << study::frames_csv_header(cell);
    cells_file_ << study::cells_csv_row(cell) << std::flush;
    frames_file_ << study::frames_csv_rows(cell) << std::flush;
    return cells_file_.good() && frames_file_.good();
  }

  int job_;
  json run_;  ///< name of the run; null: not yet known
  std::filesystem::path folder_;
  std::ofstream cells_file_, frames_file_;
  SweepCells cells_;
};

void print_cells_done(const Common& common, const json& experiment) {
  if (common.json) return;
  std::string left = "";
  if (experiment.at("time_left_s").is_number()) {
    const int seconds = int(experiment.at("time_left_s").get<double>());
    left = fmt::format(", {}:{:02} min left", seconds / 60, seconds % 60);
  }
  study::print_progress(fmt::format("{} of {} cells{}", experiment.at("cells_done").get<int>(),
                                    experiment.at("cells_total").get<int>(), left));
}

/// Fetches the cells of this run that are new since the last call. Returns the result of
/// experiment.get.
Answer fetch(const Common& common, Fetched& fetched) {
  Answer experiment = call(common, "experiment.get", json::object());
  if (!experiment || !fetched.is_own(*experiment)) return experiment;
  for (const json& summary : experiment->at("cells")) {
    if (fetched.has(summary) || stop_asked != 0) continue;
    Answer cell = call(common, "experiment.cell", {{"cell", summary.at("cell")}});
    if (!cell) return cell;
    if (!Fetched::is_same(*cell, summary)) break;  // another run has begun since
    if (const auto added = fetched.add(std::move(*cell)); !added) {
      const Error& why = added.error();
      return tl::make_unexpected(
          CallFailure{true, {{"message", text_of(why)}, {"data", {{"field", why.field}}}}});
    }
  }
  print_cells_done(common, *experiment);
  return experiment;
}

/// Polls the job until it ends, fetching cells as they are measured. Ctrl-C cancels the job.
/// Returns the last result of job.get.
Answer follow(const Common& common, Fetched& fetched) {
  const json job{{"job", fetched.job()}};
  while (true) {
    Answer report = call(common, "job.get", job);
    if (stop_asked != 0) {
      report = call(common, "job.cancel", job);
      if (!report) return report;
      stop_asked = 0;  // a second Ctrl-C stops the fetching
    } else if (!report) {
      return report;
    }
    if (report->at("result").is_object()) fetched.set_run(report->at("result").at("run"));
    if (Answer experiment = fetch(common, fetched); !experiment && stop_asked == 0) {
      return experiment;
    }
    if (report->at("state") != "running") return report;
    std::this_thread::sleep_for(kCellPollInterval);
  }
}

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
  const cv::Mat raw(waves.height, waves.width, CV_32FC1, const_cast<float*>(waves.pixels.data()));
  return phase_colours(raw, scale, kPaper);
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

std::size_t next_gain(const json& request) {
  const auto gains = request.at("gains_db").get<std::vector<double>>();
  const auto next = std::min_element(gains.begin(), gains.end(), [](double a, double b) {
    return std::abs(a - kResidualGainDb) < std::abs(b - kResidualGainDb);
  });
  return std::size_t(next - gains.begin());
}

std::vector<float> introduced_waves(const json& aberration, const std::vector<int>& modes_j) {
  std::vector<float> waves(modes_j.size(), 0.0F);
  for (const json& mode : aberration.at("modes")) {
    const auto at = std::find(modes_j.begin(), modes_j.end(), mode.at("j").get<int>());
    if (at != modes_j.end())
      waves[std::size_t(at - modes_j.begin())] = mode.at("waves").get<float>();
  }
  return waves;
}

struct Residual {
  Image<float> waves;
  std::string title, more;
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
  residual.title = study::arm_name(cell) + ", residual";
  residual.more =
      fmt::format("{:.3g} rad^2, +-{:.3f} wave", cell.at("variances_rad2").at(*frame).get<double>(),
                  largest(residual.waves));
  return residual;
}

/// Writes experiment-images-charge-L.png for each charge L that has stored frames. It shows these
/// frames side by side, with unscaled grey levels. Errors: a file cannot be written.
Result<void> draw_camera_frames(const SweepCells& cells, const std::filesystem::path& folder) {
  std::map<int, Row> rows;
  for (const auto& [number, cell] : cells) {
    const json& kept = cell.at("picture");
    if (kept.is_null()) continue;
    const int width = kept.at("width").get<int>(), height = kept.at("height").get<int>();
    auto bytes = bytes_of(kept.at("base64").get_ref<const std::string&>(),
                          std::size_t(width) * std::size_t(height));
    if (!bytes) {
      return fail(Errc::internal, "picture",
                  "the daemon sent an incomplete image: repeat the command");
    }
    const cv::Mat grey(height, width, CV_8UC1, bytes->data());
    cv::Mat picture;
    cv::cvtColor(grey, picture, cv::COLOR_GRAY2BGR);
    picture.setTo(cv::Scalar(60, 60, 255), grey == 255);
    rows[cell.at("charge").get<int>()].add(
        picture,
        fmt::format("charge {}, {:g} dB", cell.at("charge").get<int>(),
                    cell.at("gain_db").get<double>()),
        fmt::format("brightest {:g} DN; red: full scale", cell.at("peak_dn").get<double>()));
  }
  for (const auto& [charge, row] : rows) {
    auto written =
        write_image(folder / fmt::format("experiment-images-charge-{}.png", charge), row.picture());
    if (!written) return written;
  }
  return {};
}

/// Writes experiment-residual.png, as in the paper, for the measured gain nearest to 36 dB. Shows
/// the second aberration (or the only one) and each arm's residual wavefront, on one colour scale.
/// The residual comes from the frame with the cell's median variance. Writes nothing if no cell was
/// measured at this gain.
Result<void> draw_residuals(const json& request, const SweepCells& cells,
                            const std::filesystem::path& folder) {
  const std::size_t aberration = std::min<std::size_t>(1, request.at("aberrations").size() - 1);
  const std::size_t arms = request.at("arms").size(), gain = next_gain(request);
  const std::size_t first = (aberration * request.at("gains_db").size() + gain) * arms;
  const json& introduced = request.at("aberrations").at(aberration);
  Row row;
  for (std::size_t k = 0; k < arms; ++k) {
    const auto cell = cells.find(int(first + k));
    if (cell == cells.end()) continue;
    const auto modes_j = cell->second.at("modes_j").get<std::vector<int>>();
    const PhaseMap map(modes_j, kPanelPx);
    const std::vector<float> waves = introduced_waves(introduced, modes_j);
    Image<float> shown;
    map.render(waves, shown);
    const double scale = largest(shown);  // one colour scale for all panels
    if (row.picture().empty()) {
      row.add(coloured(shown, scale),
              fmt::format("introduced, {:g} dB", request.at("gains_db").at(gain).get<double>()),
              fmt::format("+-{:.3f} wave", scale));
    }
    const auto residual = residual_of(cell->second, map, waves);
    if (!residual) continue;
    row.add(coloured(residual->waves, scale), residual->title, residual->more);
  }
  if (row.picture().empty()) return {};
  return write_image(folder / "experiment-residual.png", row.picture());
}

/// Writes summary, table, figures and images of the gain sweep.
Result<void> write_all(const json& experiment, const SweepCells& cells,
                       const std::filesystem::path& folder) {
  json summary = study::sweep_summary(experiment);
  summary["version"] = OVWS_VERSION;
  const auto draw_images = [&]() -> Result<void> {
    if (auto done = draw_camera_frames(cells, folder); !done) return done;
    return draw_residuals(experiment.at("request"), cells, folder);
  };
  auto done = study::write_text(study::sweep_table(experiment), folder / "table.txt");
  if (!done) return done;
  return write_findings(summary, study::sweep_figures(experiment), folder, draw_images);
}

void print_bench(const json& experiment) {
  const json& bench = experiment.at("bench");
  print("run {} of {}: {} us at every gain, {}, {} x {} px\n",
        experiment.at("run").get<std::string>(), experiment.at("t_begun").get<std::string>(),
        bench.at("exposure_us").get<double>(), bench.at("pixel_format").get<std::string>(),
        bench.at("roi").at("width").get<int>(), bench.at("roi").at("height").get<int>());
  if (experiment.at("not_kept_reason").is_string()) {
    print("the results do not survive a restart of the daemon: {}\n",
          experiment.at("not_kept_reason").get<std::string>());
  }
}

int write_and_print_findings(const Common& common, Fetched& fetched,
                             const std::filesystem::path& folder) {
  const Answer experiment = fetch(common, fetched);
  if (!experiment) return report_failure(common, experiment.error());
  if (!fetched.is_own(*experiment) || experiment->at("complete") != true) {
    return report(common, {Errc::refused, "",
                           "another gain sweep has started since: repeat this command when it has "
                           "ended to fetch this one"});
  }
  auto written = write_all(*experiment, fetched.cells(), folder);
  if (!fetched.write_in_order()) {
    written = no_csv();
  }
  const json summary = study::sweep_summary(*experiment);
  if (common.json) {
    print("{}\n", json_text(summary));
  } else {
    print_bench(*experiment);
    print("{}\n", study::sweep_table(*experiment));
    for (const json& one : summary.at("comparisons")) {
      print("{} is below {} in {} of {} cells\n", one.at("arm").get<std::string>(),
            one.at("other").get<std::string>(), one.at("lower").get<int>(),
            one.at("cells").get<int>());
    }
    print("see {}\n", folder.string());
  }
  return written ? kOk : report(common, written.error());
}

/// Message for a job that did not finish. Errors in the fields `anew` and `reference_frames`
/// already say what to do; for all other errors, adds the hint to continue.
std::string why_it_ended(const json& report, std::size_t cells) {
  const json& error = report.at("error");
  const std::string state = report.at("state").get<std::string>();
  const std::string why = error.is_object() ? error.value("message", state) : state;
  const json field = error.is_object() ? error.at("data").value("field", json()) : json();
  if (field == "anew" || field == "reference_frames") return why;
  return fmt::format("{}; {} cells are measured and stored: repeat the command to continue", why,
                     cells);
}

}  // namespace

int run_experiment(const Common& common, const json& params, const std::filesystem::path& folder) {
  std::signal(SIGINT, note_interrupt);
  const Answer started = start(common, params);
  if (!started) return report_failure(common, started.error());
  Fetched fetched(started->at("job").get<int>(), folder);
  const Answer ended = follow(common, fetched);
  if (!common.json) study::print_progress("");
  if (!ended) return report_failure(common, ended.error());
  const std::string state = ended->at("state").get<std::string>();
  if (state == "done") return write_and_print_findings(common, fetched, folder);
  return report(common, {Errc::refused, "", why_it_ended(*ended, fetched.cells().size())});
}

}  // namespace ovws::cli
