/// ovws study: the accuracy studies, with figures.
#include <chrono>
#include <fstream>
#include <nlohmann/json.hpp>

#include "daemon/cli/commands.hpp"
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
};

Result<nlohmann::json> run_study(const StudyOptions& options) {
  study::Settings settings;
  settings.folder = options.folder;
  settings.quick = options.quick;
  settings.seed = options.seed;
  settings.threads = options.threads > 0 ? options.threads : study::all_cores();
  std::error_code error;
  std::filesystem::create_directories(settings.folder, error);
  if (error) {
    return fail(Errc::unavailable, "output",
                options.folder + " cannot be made: " + error.message());
  }
  const auto chosen =
      std::find_if(study::kStudies.begin(), study::kStudies.end(),
                   [&](const study::Study& one) { return one.name == options.name; });
  const auto started = std::chrono::steady_clock::now();
  auto summary = chosen->run(settings);
  if (!summary) return summary;
  (*summary)["quick"] = options.quick;
  (*summary)["seed"] = options.seed;
  (*summary)["version"] = OVWS_VERSION;
  (*summary)["took_s"] =
      std::chrono::duration<double>(std::chrono::steady_clock::now() - started).count();
  std::ofstream file(settings.folder / "summary.json");
  file << summary->dump(2) << "\n";
  file.close();
  if (!file) return fail(Errc::unavailable, "output", options.folder + "/summary.json");
  return summary;
}

int study_command(const Common& common, const StudyOptions& options) {
  const auto summary = run_study(options);
  if (!summary) return report(common, summary.error());
  if (common.json) {
    print("{}\n", summary->dump());
  } else {
    print("{}: {:.0f} s, see {}\n", options.name, (*summary)["took_s"].get<double>(),
          options.folder);
  }
  return kOk;
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
  command->add_option("name", options->name, help)->required()->check(CLI::IsMember(names));
  command->add_option("--output,-o", options->folder, "folder for the files")->required();
  command->add_flag("--quick", options->quick, "fewer levels and realisations");
  command->add_option("--threads", options->threads, "0: all cores")
      ->check(CLI::Range(0, 1024))
      ->capture_default_str();
  command->add_option("--seed", options->seed, "of all that is random")->capture_default_str();
  command->callback([&common, &status, options] { status = study_command(common, *options); });
}

}  // namespace ovws::cli
