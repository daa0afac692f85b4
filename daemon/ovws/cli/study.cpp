/// ovws study: runs accuracy studies, offline or on a daemon's bench, and writes their figures.
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "daemon/ovws/cli/commands.hpp"
#include "daemon/ovws/cli/experiment.hpp"
#include "daemon/ovws/cli/findings.hpp"
#include "daemon/ovws/cli/rejection.hpp"
#include "daemon/ovws/study/parallel.hpp"
#include "daemon/ovws/study/studies.hpp"

namespace ovws::cli {
namespace {

struct StudyOptions {
  std::string name;
  std::string folder;
  bool quick = false;
  int threads = 0;  ///< 0: one per core
  std::uint64_t seed = 1;
  std::string params;  ///< JSON; only for studies on a bench
  double seconds = 60.0;
};

// These run on a daemon's bench.
constexpr const char* kExperiment = "experiment";
constexpr const char* kRejection = "rejection";

/// Creates the folder and checks that it is writable, before minutes of work.
Result<void> check_folder(const std::filesystem::path& folder) {
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (!error && ::access(folder.c_str(), W_OK | X_OK) != 0) {
    error.assign(errno, std::generic_category());
  }
  if (!error) return {};
  return fail(Errc::unavailable, "output",
              folder.string() + " is not writable: " + error.message());
}

/// Prints the current step on standard error, like study::Progress only on a terminal.
void print_step(const std::string& what) {
  if (::isatty(STDERR_FILENO) == 0) return;
  fmt::print(stderr, "\r\033[K{}", what);
  std::fflush(stderr);
}

study::Findings run_study(const StudyOptions& options) {
  study::Settings settings;
  settings.quick = options.quick;
  settings.seed = options.seed;
  settings.threads = options.threads > 0 ? options.threads : study::all_cores();
  const auto chosen =
      std::find_if(study::kStudies.begin(), study::kStudies.end(),
                   [&](const study::Study& one) { return one.name == options.name; });
  const auto started = std::chrono::steady_clock::now();
  print_step(options.name + ": preparing");
  study::Findings found = chosen->run(settings);
  found.summary["quick"] = options.quick;
  found.summary["seed"] = options.seed;
  found.summary["version"] = OVWS_VERSION;
  found.summary["took_s"] =
      std::chrono::duration<double>(std::chrono::steady_clock::now() - started).count();
  return found;
}

int bench_command(const Common& common, const StudyOptions& options) {
  nlohmann::json params = nlohmann::json::object();
  const bool is_experiment = options.name == kExperiment;
  if (is_experiment && options.quick) params = {{"frames", 20}, {"gains_db", {10, 16, 28, 40}}};
  if (!options.params.empty()) {
    const auto given = nlohmann::json::parse(options.params, nullptr, false);
    if (!given.is_object()) {
      fmt::print(stderr, "ovws: the parameters are not a JSON object: {}\n", options.params);
      return kUsage;
    }
    params.update(given);
  }
  if (is_experiment) return run_experiment(common, params, options.folder);
  return run_rejection(common, params, options.seconds, options.folder);
}

int study_command(const Common& common, const StudyOptions& options) {
  if (const auto usable = check_folder(options.folder); !usable) {
    return report(common, usable.error());
  }
  if (options.name == kExperiment || options.name == kRejection) {
    return bench_command(common, options);
  }
  const study::Findings found = run_study(options);
  print_step(options.name + ": drawing the figures");
  const auto written = write_findings(options.name, found.summary, found.figures, options.folder);
  print_step("");
  if (common.json) {
    print("{}\n", found.summary.dump());
  } else {
    print("{}: {:.0f} s, see {}\n", options.name, found.summary["took_s"].get<double>(),
          options.folder);
  }
  return written ? kOk : report(common, written.error());
}

}  // namespace

void add_study(CLI::App& app, const Common& common, int& status) {
  auto* command = app.add_subcommand("study",
                                     "run a study and write its figures, numbers and summary to a "
                                     "folder; experiment and rejection "
                                     "run on a daemon's bench, the others work offline");
  auto options = std::make_shared<StudyOptions>();
  std::vector<std::string> names;
  std::string help = "one of:";
  for (const study::Study& one : study::kStudies) {
    names.emplace_back(one.name);
    help += std::string("\n") + one.name + ": " + one.what;
  }
  names.emplace_back(kExperiment);
  help += std::string("\n") + kExperiment +
          ": the paper's experiment on a daemon's bench: residual variance against camera gain";
  names.emplace_back(kRejection);
  help += std::string("\n") + kRejection +
          ": on a daemon's bench, the closed loop's disturbance rejection by frequency";
  command->add_option("name", options->name, help)->required()->check(CLI::IsMember(names));
  command
      ->add_option("--output,-o", options->folder,
                   "folder for the files; replaces those of the same study")
      ->required();
  command->add_flag("--quick", options->quick,
                    "fewer levels and realisations: seconds instead of minutes");
  command->add_option("--threads", options->threads, "number of threads; 0: one per core")
      ->check(CLI::Range(0, 1024))
      ->capture_default_str();
  command->add_option("--seed", options->seed, "random seed: the same seed gives the same numbers")
      ->check(CLI::NonNegativeNumber)
      ->capture_default_str();
  command
      ->add_option("--seconds", options->seconds,
                   "rejection only: duration of each recording, loop open and loop closed")
      ->check(number_from(5.0, 86400.0))
      ->capture_default_str();
  command->add_option(
      "--params", options->params,
      "experiment and rejection only: params of experiment.gain_sweep or loop.close as a JSON "
      "object; see ovws describe");
  command->callback([&common, &status, options] { status = study_command(common, *options); });
}

}  // namespace ovws::cli
