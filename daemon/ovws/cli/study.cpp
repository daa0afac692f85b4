/// ovws study: runs accuracy studies, offline or on a daemon's bench, and writes their figures.
#include <unistd.h>

#include <cerrno>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <numeric>

#include "daemon/ovws/cli/commands.hpp"
#include "daemon/ovws/cli/study_files.hpp"
#include "daemon/ovws/parts/part_file.hpp"
#include "daemon/ovws/parts/provenance.hpp"
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
  auto part = PartWriter::make(options.folder, part_name(shard), head);
  if (!part) return fail(part.error());
  const auto results = study::measure_items(work, options.name, items, threads_of(options));
  study::print_progress("");
  for (std::size_t k = 0; k < items.size(); ++k) part->add(items[k], results[k]);
  if (auto done = part->finish(); !done) return fail(done.error());
  return part->path();
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
  if (common.json) {
    print("{}\n", json_text(found.summary));
  } else {
    print("{}: {:.0f} s, see {}\n", options.name, provenance.at("took_s").get<double>(),
          options.folder);
  }
  return written ? kOk : report(common, written.error());
}

int study_command(const Common& common, const StudyOptions& options) {
  const bool on_a_bench = options.name == kExperiment || options.name == kRejection;
  if (on_a_bench && options.shard) {
    return report(common,
                  {Errc::refused, "shard",
                   options.name + " measures one bench in real time, which cannot be shared "
                                  "out: leave out --shard"});
  }
  if (const auto usable = check_folder(options.folder); !usable) {
    return report(common, usable.error());
  }
  if (on_a_bench) return bench_command(common, options);
  if (options.shard) {
    const auto part = write_study_part(options, *options.shard);
    return part ? report_file(common, *part) : report(common, part.error());
  }
  const study::Work work = work_of(options);
  const auto results = measure_all(options, work);
  return finish_study(common, options, work, results, host_facts());
}

}  // namespace ovws::cli
