/// ovws study: runs accuracy studies, offline or on a daemon's bench, and writes their figures.
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "daemon/ovws/cli/commands.hpp"
#include "daemon/ovws/cli/study_files.hpp"
#include "daemon/ovws/study/parallel.hpp"
#include "daemon/ovws/study/studies.hpp"
#include "proto/json_text.hpp"

namespace ovws::cli {
namespace {

/// Creates the output folder and checks that it is writable, before a study that takes minutes.
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

study::Findings run_study(const StudyOptions& options) {
  study::Settings settings;
  settings.quick = options.quick;
  settings.seed = options.seed;
  settings.threads = options.threads > 0 ? options.threads : study::all_cores();
  const auto chosen =
      std::find_if(study::kStudies.begin(), study::kStudies.end(),
                   [&](const study::Study& one) { return one.name == options.name; });
  const auto started = std::chrono::steady_clock::now();
  study::print_progress(options.name + ": preparing");
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
    const auto given = json_of(options.params);
    if (!given.is_object()) {
      fmt::print(stderr, "ovws: the parameters are not a JSON object: {}\n", options.params);
      return kUsage;
    }
    params.update(given);
  }
  if (is_experiment) return run_experiment(common, params, options.folder);
  return run_rejection(common, params, options.seconds, options.folder);
}

}  // namespace

int study_command(const Common& common, const StudyOptions& options) {
  if (const auto usable = check_folder(options.folder); !usable) {
    return report(common, usable.error());
  }
  if (options.name == kExperiment || options.name == kRejection) {
    return bench_command(common, options);
  }
  const study::Findings found = run_study(options);
  study::print_progress(options.name + ": drawing the figures");
  auto written = remove_findings(options.name, options.folder);
  if (written) written = write_findings(found.summary, found.figures, options.folder);
  study::print_progress("");
  if (common.json) {
    print("{}\n", json_text(found.summary));
  } else {
    print("{}: {:.0f} s, see {}\n", options.name, found.summary["took_s"].get<double>(),
          options.folder);
  }
  return written ? kOk : report(common, written.error());
}

}  // namespace ovws::cli
