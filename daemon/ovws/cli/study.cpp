/// ovws study: runs accuracy studies, offline or on a daemon's bench, and writes their figures.
#include <filesystem>
#include <nlohmann/json.hpp>
#include <numeric>

#include "daemon/ovws/cli/command_line.hpp"
#include "daemon/ovws/cli/commands.hpp"
#include "daemon/ovws/cli/study_files.hpp"
#include "daemon/ovws/parts/part_file.hpp"
#include "daemon/ovws/parts/provenance.hpp"
#include "daemon/ovws/study/parallel.hpp"
#include "daemon/ovws/study/studies.hpp"

namespace ovws::cli {
namespace {

constexpr const char* kExperiment = "experiment";
constexpr const char* kRejection = "rejection";

int threads_of(const StudyOptions& options) {
  return options.threads > 0 ? options.threads : study::all_cores();
}

study::Work work_of(const StudyOptions& options) {
  study::print_progress(options.name + ": preparing");
  return study::study_named(options.name)->prepare({options.quick, options.seed});
}

/// Measures the items of one shard and writes them as a part.
Result<std::filesystem::path> write_study_part(const StudyOptions& options, const Shard& shard) {
  const study::Work work = work_of(options);
  std::vector<std::size_t> items;
  for (auto k = std::size_t(shard.number - 1); k < work.items; k += std::size_t(shard.of)) {
    items.push_back(k);
  }
  PartHead head;
  head.part_of = kPartOfStudy + options.name;
  head.version = OVWS_VERSION;
  head.options = {{"quick", options.quick}, {"seed", options.seed}};
  head.items = work.items;
  head.share = text_of(shard);
  const auto measure_items = [&](const AddItem& add) -> Result<void> {
    const auto results = study::measure_items(work, options.name, items, threads_of(options));
    study::print_progress("");
    for (std::size_t k = 0; k < items.size(); ++k) add(items[k], results[k]);
    return {};
  };
  return write_part(options.folder, part_name(shard), head, measure_items);
}

/// Runs a whole study, and returns the text of each item's result.
std::vector<std::string> measure_all(const StudyOptions& options, const study::Work& work) {
  std::vector<std::size_t> items(work.items);
  std::iota(items.begin(), items.end(), std::size_t{0});
  return study::measure_items(work, options.name, items, threads_of(options));
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

int study_command(const Common& common, const StudyOptions& options) {
  const bool on_a_bench = options.name == kExperiment || options.name == kRejection;
  if (on_a_bench && options.shard) {
    return report(common,
                  {Errc::refused, "shard",
                   options.name + " measures one bench in real time, which cannot be shared "
                                  "out: leave out --shard"});
  }
  // Before a study that takes minutes.
  if (const auto usable = make_folder(options.folder); !usable) {
    return report(common, usable.error());
  }
  if (on_a_bench) return bench_command(common, options);
  if (options.shard) {
    const auto part = write_study_part(options, *options.shard);
    return part ? report_file(common, part->string()) : report(common, part.error());
  }
  const study::Work work = work_of(options);
  const auto results = measure_all(options, work);
  return finish_study(common, options, work, results, host_facts());
}

}  // namespace

int finish_study(const Common& common, const StudyOptions& options, const study::Work& work,
                 const std::vector<std::string>& results, const nlohmann::json& provenance) {
  std::vector<nlohmann::json> read;
  for (const std::string& text : results) read.push_back(study::result_of(text));
  study::Findings found = work.find(read);
  found.summary["quick"] = options.quick;
  found.summary["seed"] = options.seed;
  found.summary["version"] = OVWS_VERSION;
  study::print_progress(options.name + ": drawing the figures");
  const std::filesystem::path folder = options.folder;
  auto written = remove_findings(options.name, folder);
  if (written) written = write_provenance(provenance, folder / kProvenance);
  if (written) written = write_findings(found.summary, found.figures, folder);
  study::print_progress("");
  print_result(common, found.summary,
               fmt::format("{}: {:.0f} s, see {}", options.name,
                           provenance.at("took_s").get<double>(), options.folder));
  return written ? kOk : report(common, written.error());
}

void add_study(CLI::App& app, const Common& common, int& status) {
  auto [command, options] = add_command(
      app, common, status, "study",
      "run a study and write its figures, numbers and summary to a folder; experiment and "
      "rejection run on a daemon's bench, the others work offline",
      study_command);
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
          ": on a daemon's bench, the closed loop's disturbance rejection by frequency, with the "
          "laws integrator, optimised and predictor, or with the law that --params names";
  command.add_option("name", options.name, help)->required()->check(CLI::IsMember(names));
  command
      .add_option("--output,-o", options.folder,
                  "folder for the files; replaces those of the same study")
      ->required();
  command.add_flag(
      "--quick", options.quick,
      "fewer levels and realisations: seconds instead of minutes; rejection ignores it");
  command.add_option("--threads", options.threads, "number of threads; 0: one per core")
      ->check(CLI::Range(0, 1024))
      ->capture_default_str();
  command.add_option("--seed", options.seed, "random seed: the same seed gives the same numbers")
      ->check(CLI::NonNegativeNumber)
      ->capture_default_str();
  add_shard(
      command, options.shard,
      "measure only every N-th item of the study, 1/N to N/N, and write a part for ovws merge "
      "instead of the figures");
  command
      .add_option(
          "--seconds", options.seconds,
          "rejection only: duration of each recording: one with the loop open, and one with each "
          "law")
      ->check(number_from(5.0, 86400.0))
      ->capture_default_str();
  command.add_option("--params", options.params,
                     "experiment and rejection only: what to measure (see the guide), or params "
                     "of loop.close as a JSON "
                     "object; see ovws describe");
}

}  // namespace ovws::cli
