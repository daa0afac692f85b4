/// What commands of ovws use of each other. Each function that returns an int prints its result or
/// its error and returns the exit code.
#pragma once

#include <cstdint>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "config/config.hpp"
#include "daemon/examine/finding.hpp"
#include "daemon/ovws/cli/request.hpp"
#include "daemon/ovws/parts/share.hpp"
#include "daemon/ovws/study/work.hpp"

namespace CLI {
class App;
class Option;
}  // namespace CLI

namespace ovws::cli {

/// Whether the reader of standard output (a pipe or terminal) has gone.
bool output_has_no_reader();

/// Prints the name of a file that was written.
inline int report_file(const Common& common, const std::string& file) {
  return print_result(common, {{"file", file}}, file);
}

/// Whether input and output are a terminal that can show the full screen (TERM is not "dumb").
bool can_show_screen();
/// Shows the full screen of `watch` until q, Ctrl-C or the end of the terminal.
int show_screen(Common common);

/// The checks of `ovws doctor`; takes some seconds. `endpoint`: the option --endpoint; if it is not
/// given, the endpoint in the configuration is asked.
examine::Findings examine_bench(const Common& common, const std::string& config_path,
                                const CLI::Option* endpoint);

/// Values of a known camera that replace those of a RefineSetup.
struct RefineOverrides {
  std::optional<double> electrons_per_dn, read_noise_e, black_level_dn, saturation_dn;

  RefineSetup on(RefineSetup setup) const;
};
/// Adds their options, which need the flag `refine`.
void add_refine_camera(CLI::App& command, RefineOverrides& camera, CLI::Option* refine,
                       const char* electrons_help);

struct ImageOptions {
  std::string config_path;
  std::string modes;
  std::string norm = "rms";
  std::string output;
};

struct FarFieldOptions : ImageOptions {
  std::optional<double> peak_e;
  std::optional<double> total_e;
  double read_noise_e = 5.0;
  double gain_db = 0.0;
  int bits = 8;
  std::uint64_t seed = 1;
  bool noise_free = false;
};

/// Writes the camera image of a configuration; `options.config_path` is not read.
Result<void> write_farfield(const Config& config, const FarFieldOptions& options);

// Accuracy studies. `experiment` and `rejection` run on a daemon's bench, all others offline.

struct StudyOptions {
  std::string name;
  std::string folder;
  bool quick = false;
  int threads = 0;  ///< 0: one per core
  std::uint64_t seed = 1;
  std::string params;  ///< JSON; only for `experiment` and `rejection`
  double seconds = 60.0;
  std::optional<Shard> shard;  ///< writes one part instead of the figures
};

/// Makes and writes the findings from the results of all items.
int finish_study(const Common& common, const StudyOptions& options, const study::Work& work,
                 const std::vector<std::string>& results, const nlohmann::json& provenance);

// The parts of `ovws study --shard` and `ovws replay -o`.

inline constexpr const char *kPartOfStudy = "study ", *kPartOfReplay = "replay";
/// Name of a part's file, without extension.
std::string part_name(const Shard& shard);
std::string part_name(const Positions& range);

/// The paper's gain sweep on a daemon's bench, with params of GainSweep. Writes each cell as soon
/// as it is measured; table, figures and summary at the end. The first cell replaces the study's
/// earlier files in the folder. On return, also after Ctrl-C, the bench is as before.
int run_experiment(const Common& common, const nlohmann::json& params,
                   const std::filesystem::path& folder);

/// Disturbance rejection of the closed loop on a daemon's bench. Records the wavefront for
/// `seconds` with the loop open. Then closes the loop with `params` (see loop.close) and records
/// for `seconds` again. Writes rejection-spectra, rejection and summary. On return, also after
/// Ctrl-C, the loop is open and has its previous correction.
int run_rejection(const Common& common, const nlohmann::json& params, double seconds,
                  const std::filesystem::path& folder);

}  // namespace ovws::cli
