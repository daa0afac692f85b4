/// Subcommands of ovws. Each function prints its result or its error and returns the exit code.
/// command_line.hpp declares the syntax that fills in the options.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "config/config.hpp"
#include "core/control/refine_settings.hpp"
#include "daemon/ovws/parts/share.hpp"
#include "daemon/ovws/study/work.hpp"
#include "daemon/shared/client.hpp"

namespace ovws::cli {

/// Whether the reader of standard output (a pipe or terminal) has gone.
bool output_has_no_reader();

// Commands that need a daemon.

int show_status(const Common& common);
/// `name`: one method or stream; empty: the list of all.
int describe(const Common& common, const std::string& name);

struct CallOptions {
  std::string method;
  std::vector<std::string> params;  ///< words, see params_of
  bool wait = false;
};

int call_method(const Common& common, const CallOptions& options);

// Plain verbs. Without a value each shows the present one.

int exposure_verb(const Common& common, const std::string& time);  ///< "2ms" (seconds_of), "auto"
int gain_verb(const Common& common, const std::string& gain);      ///< "12"; see decibels_of
int rate_verb(const Common& common, const std::string& rate);      ///< "100"; see hertz_of
/// `words`: MODE=WAVES, or norm=unit.
int aberrate_verb(const Common& common, const std::vector<std::string>& words);
int clear_verb(const Common& common);
int focus_verb(const Common& common, const std::vector<std::string>& words);  ///< of focus.run
/// `words`: further params of reference.take.
int reference_verb(const Common& common, const std::string& action,
                   const std::vector<std::string>& words);
/// `action`: close, open, pause or resume; `words`: params of the method.
int loop_verb(const Common& common, const std::string& action,
              const std::vector<std::string>& words);

/// Records until the duration has passed, or until Ctrl-C, and shows the progress. `words`: a name,
/// a duration, and params of record.start as KEY=VALUE, each may be left out; none: shows the
/// state.
int record_verb(const Common& common, const std::vector<std::string>& words);

struct WatchOptions {
  std::string topic = "wavefront";
  int count = 0;  ///< number of messages to show; 0: until Ctrl-C
  bool plain = false;
  std::optional<double> timeout_s;  ///< longest wait for the next message; none: no limit
};

int watch(const Common& common, const WatchOptions& options);
/// Whether input and output are a terminal that can show the full screen (TERM is not "dumb").
bool can_show_screen();
/// Shows the full screen of `watch` until q, Ctrl-C or the end of the terminal.
int show_screen(Common common);

/// Writes camera image and wavefront as files. `prefix`: start of the file names, or a folder.
int save_snapshot(const Common& common, const std::string& prefix);

/// Serves HTTP at `address`, "ADDRESS:PORT", until a signal.
int serve_metrics(Common common, const std::string& address);

/// Runs the checks of `ovws doctor`. `endpoint`: the daemon's; empty: the endpoint in the
/// configuration.
int check_bench(const Common& common, const std::string& config_path, const std::string& endpoint);

struct AcceptanceOptions {
  std::string output;     ///< HTML file; empty: none
  double seconds = 60.0;  ///< for noise and drift
  bool quick = false;
  bool open_loop = false;  ///< opens a closed loop for the check
  bool no_loop = false;    ///< does not close the loop
};

/// Measures the bench and prints the report of `ovws check`. Returns kError if a verdict is bad.
int check_acceptance(const Common& common, const AcceptanceOptions& options);

// Commands that work offline.

struct ImageOptions {
  std::string config_path;
  std::string modes;
  std::string norm = "rms";
  std::string output;
};

int save_hologram(const Common& common, const ImageOptions& options);

struct FarFieldOptions {
  ImageOptions picture;
  std::optional<double> peak_e;
  std::optional<double> total_e;
  double read_noise_e = 5.0;
  double gain_db = 0.0;
  int bits = 8;
  std::uint64_t seed = 1;
  bool noise_free = false;
};

int save_farfield(const Common& common, const FarFieldOptions& options);
/// Writes the image of a configuration; `options.picture.config_path` is not read.
Result<void> write_farfield(const Config& config, const FarFieldOptions& options);

struct MeasureOptions {
  std::string config_path;
  std::string reference;
  bool model_reference = false;
  std::string tracker;
  std::string mode_operator;
  bool refine = false;
  RefineCamera camera;  ///< used with `refine` only
  bool spot_amplitudes = false;
  std::vector<std::string> images;
};

int measure_images(const Common& common, const MeasureOptions& options);

struct KeygenOptions {
  std::string output;
  bool replace = false;
};

int make_keys(const Common& common, const KeygenOptions& options);

/// Values that replace those of the recording's configuration; see RefineSetup.
struct RefineOverrides {
  std::optional<double> electrons_per_dn, read_noise_e, black_level_dn, saturation_dn;
};

struct ReplayOptions {
  std::string path;
  double speed = 0.0;  ///< factor to the recorded speed; 0: as fast as possible
  bool step = false;
  bool print_frames = false;
  std::optional<Positions> frames;  ///< positions in the recording; none: all
  std::optional<Shard> shard;       ///< instead of `frames`
  std::string folder;               ///< for a part; empty: prints the results
  bool refine = false;
  RefineOverrides camera;  ///< used with `refine` only
};

int replay_recording(const Common& common, const ReplayOptions& options);

struct ExportOptions {
  std::string path;
  std::string prefix;  ///< begin of the files' names; empty: the recording's name
  bool csv = false, spots = false, images = false;
};

int export_recording(const Common& common, const ExportOptions& options);

// Accuracy studies. `experiment` and `rejection` run on a daemon's bench, all others offline.

inline constexpr const char* kExperiment = "experiment";
inline constexpr const char* kRejection = "rejection";

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

int study_command(const Common& common, const StudyOptions& options);

/// Makes and writes the findings from the results of all items.
int finish_study(const Common& common, const StudyOptions& options, const study::Work& work,
                 const std::vector<std::string>& results, const nlohmann::json& provenance);

struct MergeOptions {
  std::vector<std::string> parts;
  std::string folder;
};

/// Joins the parts of a study into its figures, or those of a replay into one list of frames.
int merge_parts(const Common& common, const MergeOptions& options);

// The parts of `ovws study --shard` and `ovws replay -o`.

inline constexpr const char *kPartOfStudy = "study ", *kPartOfReplay = "replay";
/// Name of a part's file, without extension.
std::string part_name(const Shard& shard);
std::string part_name(const Positions& range);
/// Prints the name of a file that was written.
int report_file(const Common& common, const std::filesystem::path& file);

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
