#include "daemon/ovws/cli/experiment.hpp"

#include <algorithm>
#include <chrono>
#include <csignal>
#include <fstream>
#include <thread>

#include "daemon/ovws/cli/experiment_pictures.hpp"
#include "daemon/ovws/cli/study_files.hpp"
#include "daemon/ovws/study/gain_sweep_report.hpp"
#include "daemon/shared/client.hpp"
#include "proto/json_text.hpp"

namespace ovws::cli {
namespace {

using namespace std::chrono_literals;
using nlohmann::json;

constexpr auto kPollInterval = 300ms;
constexpr int kStartTries = 10;  // a cancelled job may still be ending
constexpr int kRefusedCode = -32000;

volatile std::sig_atomic_t interrupted = 0;

void note_interrupt(int) {
  interrupted = 1;
}

using Answer = tl::expected<json, CallFailure>;

Answer start(const Common& common, const json& params) {
  for (int tries = 1;; ++tries) {
    Answer answer = call(common, "experiment.gain_sweep", params);
    const bool busy =
        !answer && answer.error().answered && answer.error().error.value("code", 0) == kRefusedCode;
    if (!busy || tries == kStartTries || interrupted != 0) return answer;
    std::this_thread::sleep_for(kPollInterval);
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
  /// Whether a result of experiment.get belongs to the job's run. The daemon may hold another run.
  bool is_own(const json& experiment) {
    if (experiment.at("job") == job_) run_ = experiment.at("run");
    return !run_.is_null() && experiment.at("run") == run_;
  }
  void set_run(const json& name) { run_ = name; }
  /// Whether this measurement of the cell was fetched (same number and start time).
  bool has(const json& summary) const {
    const auto found = cells_.find(summary.at("cell").get<int>());
    return found != cells_.end() && is_same(found->second, summary);
  }
  static bool is_same(const json& cell, const json& summary) {
    return cell.at("cell") == summary.at("cell") &&
           cell.at("t_begun_ns") == summary.at("t_begun_ns");
  }
  /// Adds a cell to both files. The first cell replaces the earlier results in the folder, so that
  /// a refused job leaves them in place.
  Result<void> add(json cell) {
    if (cells_.empty()) {
      // Earlier results may be of another run: do not mix them with these cells.
      if (auto removed = remove_findings("experiment", folder_); !removed) return removed;
      begin_files();
    }
    const bool written = write(cell);
    const int number = cell.at("cell").get<int>();
    cells_[number] = std::move(cell);
    if (!written) return no_csv();
    return {};
  }
  /// Rewrites both files in the order of cell numbers. False if one cannot be written.
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

void print_progress(const Common& common, const json& experiment) {
  if (common.json) return;
  std::string left = "";
  if (experiment.at("time_left_s").is_number()) {
    const int seconds = int(experiment.at("time_left_s").get<double>());
    left = fmt::format(", {}:{:02} min left", seconds / 60, seconds % 60);
  }
  fmt::print(stderr, "\r{} of {} cells{}      ", experiment.at("cells_done").get<int>(),
             experiment.at("cells_total").get<int>(), left);
  std::fflush(stderr);
}

/// Fetches the cells of this run that are new since the last call. Returns experiment.get's result.
Answer fetch(const Common& common, Fetched& fetched) {
  Answer experiment = call(common, "experiment.get", json::object());
  if (!experiment || !fetched.is_own(*experiment)) return experiment;
  for (const json& summary : experiment->at("cells")) {
    if (fetched.has(summary) || interrupted != 0) continue;
    Answer cell = call(common, "experiment.cell", {{"cell", summary.at("cell")}});
    if (!cell) return cell;
    if (!Fetched::is_same(*cell, summary)) break;  // another run has begun since
    if (const auto added = fetched.add(std::move(*cell)); !added) {
      const Error& why = added.error();
      return tl::make_unexpected(
          CallFailure{true, {{"message", text_of(why)}, {"data", {{"field", why.field}}}}});
    }
  }
  print_progress(common, *experiment);
  return experiment;
}

/// Polls the job until it ends, fetching cells as they are measured. Ctrl-C cancels the job.
/// Returns the last result of job.get.
Answer follow(const Common& common, Fetched& fetched) {
  const json job{{"job", fetched.job()}};
  while (true) {
    Answer report = call(common, "job.get", job);
    if (interrupted != 0) {
      report = call(common, "job.cancel", job);
      if (!report) return report;
      interrupted = 0;  // a second Ctrl-C ends the fetching
    } else if (!report) {
      return report;
    }
    if (report->at("result").is_object()) fetched.set_run(report->at("result").at("run"));
    if (Answer experiment = fetch(common, fetched); !experiment && interrupted == 0) {
      return experiment;
    }
    if (report->at("state") != "running") return report;
    std::this_thread::sleep_for(kPollInterval);
  }
}

Result<void> write_text(const std::string& text, const std::filesystem::path& path) {
  std::ofstream file(path);
  file << text;
  file.close();
  if (file) return {};
  return fail(Errc::unavailable, "output", path.string() + " cannot be written");
}

/// Writes summary, table, figures and images. Images come last, so that an error in drawing does
/// not lose the numbers.
Result<void> write_findings(const json& experiment, const SweepCells& cells,
                            const std::filesystem::path& folder) {
  json summary = study::sweep_summary(experiment);
  summary["version"] = OVWS_VERSION;
  if (auto done = write_text(json_text(summary, 2) + "\n", folder / "summary.json"); !done)
    return done;
  if (auto done = write_text(study::sweep_table(experiment), folder / "table.txt"); !done) {
    return done;
  }
  const auto figures = study::sweep_figures(experiment);
  for (const study::Figure& figure : figures) {
    if (auto done = study::write_numbers(figure, folder); !done) return done;
  }
  if (auto done = draw_camera_frames(cells, folder); !done) return done;
  if (auto done = draw_residuals(experiment.at("request"), cells, folder); !done) return done;
  for (const study::Figure& figure : figures) {
    if (auto done = study::draw(figure, folder); !done) return done;
  }
  return {};
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
  auto written = write_findings(*experiment, fetched.cells(), folder);
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

/// The message for a job that did not finish. Errors in `anew` and `reference_frames` already say
/// what to do; all others get the hint to continue.
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
  if (!common.json) fmt::print(stderr, "\n");
  if (!ended) return report_failure(common, ended.error());
  const std::string state = ended->at("state").get<std::string>();
  if (state == "done") return write_and_print_findings(common, fetched, folder);
  return report(common, {Errc::refused, "", why_it_ended(*ended, fetched.cells().size())});
}

}  // namespace ovws::cli
