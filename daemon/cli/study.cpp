/// ovws study: the accuracy studies, and what runs on a daemon's bench, with figures.
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "daemon/cli/commands.hpp"
#include "daemon/cli/experiment.hpp"
#include "daemon/cli/rejection.hpp"
#include "daemon/study/parallel.hpp"
#include "daemon/study/studies.hpp"

namespace ovws::cli {
namespace {

struct StudyOptions {
  std::string name;
  std::string folder;
  bool quick = false;
  int threads = 0;  ///< 0: as many as the machine has cores
  std::uint64_t seed = 1;
  std::string params;  ///< of what runs on a bench
  double seconds = 60.0;
};

// These run on a daemon's bench.
constexpr const char* kExperiment = "experiment";
constexpr const char* kRejection = "rejection";

/// Made, and can be written to: better known before minutes of work than after.
Result<void> check_folder(const std::filesystem::path& folder) {
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (!error && ::access(folder.c_str(), W_OK | X_OK) != 0) {
    error.assign(errno, std::generic_category());
  }
  if (!error) return {};
  return fail(Errc::unavailable, "output",
              folder.string() + " cannot be written to: " + error.message());
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
  study::Findings found = chosen->run(settings);
  found.summary["quick"] = options.quick;
  found.summary["seed"] = options.seed;
  found.summary["version"] = OVWS_VERSION;
  found.summary["took_s"] =
      std::chrono::duration<double>(std::chrono::steady_clock::now() - started).count();
  return found;
}

Result<void> write_summary(const nlohmann::json& summary, const std::filesystem::path& folder) {
  std::ofstream file(folder / "summary.json");
  file << summary.dump(2) << "\n";
  file.close();
  if (file) return {};
  return fail(Errc::unavailable, "output",
              (folder / "summary.json").string() + " cannot be written");
}

/// The pictures come last: what is missing for them must not cost the numbers.
Result<void> write_findings(const study::Findings& found, const std::filesystem::path& folder) {
  if (auto done = write_summary(found.summary, folder); !done) return done;
  for (const study::Figure& figure : found.figures) {
    if (auto done = study::write_numbers(figure, folder); !done) return done;
  }
  for (const study::Figure& figure : found.figures) {
    if (auto done = study::draw(figure, folder); !done) return done;
  }
  return {};
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
  const auto written = write_findings(found, options.folder);
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
  auto* command = app.add_subcommand("study", "accuracy studies: figures, numbers and a summary");
  auto options = std::make_shared<StudyOptions>();
  std::vector<std::string> names;
  std::string help = "one of:";
  for (const study::Study& one : study::kStudies) {
    names.emplace_back(one.name);
    help += std::string("\n") + one.name + ": " + one.what;
  }
  names.emplace_back(kExperiment);
  help += std::string("\n") + kExperiment +
          ": the paper's comparison on a daemon's bench: variance against the camera's gain";
  names.emplace_back(kRejection);
  help += std::string("\n") + kRejection +
          ": on a daemon's bench, what the closed loop leaves of what moves, by frequency";
  command->add_option("name", options->name, help)->required()->check(CLI::IsMember(names));
  command->add_option("--output,-o", options->folder, "folder for the files")->required();
  command->add_flag("--quick", options->quick, "fewer levels and realisations");
  command->add_option("--threads", options->threads, "0: all cores")
      ->check(CLI::Range(0, 1024))
      ->capture_default_str();
  command->add_option("--seed", options->seed, "of all that is random")->capture_default_str();
  command->add_option("--seconds", options->seconds, "of rejection: open, and as long closed")
      ->check(number_from(5.0, 86400.0))
      ->capture_default_str();
  command->add_option("--params", options->params,
                      "a JSON object: of experiment.gain_sweep for the experiment, of loop.close "
                      "for rejection; see ovws describe");
  command->callback([&common, &status, options] { status = study_command(common, *options); });
}

}  // namespace ovws::cli
