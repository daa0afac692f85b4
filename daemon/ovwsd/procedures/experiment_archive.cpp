#include "daemon/ovwsd/procedures/experiment_archive.hpp"

#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <utility>

#include "core/port/clock.hpp"
#include "daemon/shared/encoding.hpp"
#include "proto/json_text.hpp"

namespace ovws {
namespace {

using nlohmann::json;
using Stop = DaemonStore::Stop;

constexpr const char* kKind = "experiment";

/// JSON key for the start time of the execution that wrote a file. After `anew`, files of an
/// earlier execution are ignored even if they could not be deleted.
constexpr const char* kStamp = "run_t_begun_ns";

/// Parts of a gain-sweep run, each with its own file. An arm is one sensor; a cell is one arm with
/// one aberration at one gain. References are numbered by arm, cells and their images by cell.
enum class Part { reference, cell, picture };

/// Kind of a run's files in the state store. Images have a separate kind, because they take many
/// megabytes and are read only on request.
std::string kind_of(const ExperimentRun& run, Part part = Part::cell) {
  return fmt::format("{}{}-{}", kKind, part == Part::picture ? "-picture" : "", run.name);
}

std::string name_of(Part part, std::size_t number) {
  if (part == Part::reference) return fmt::format("reference-{:02}", number);
  return fmt::format("{}-{:05}", part == Part::picture ? "picture" : "cell", number);
}

/// The header of a run.
struct Header {
  ExperimentRun run;
  std::int64_t t_opened_ns = 0;
};
/// Decodes the header of a run; none if the file is not a valid header.
std::optional<Header> header_of(const StateItem& item) {
  const json& content = item.content;
  if (!content.is_object() || !content.contains("request") || !content.contains("bench")) {
    return std::nullopt;
  }
  const auto request = decode<GainSweep>(content["request"]);
  const json begun = content.value("t_begun_ns", json()),
             opened = content.value("t_opened_ns", json());
  if (!request || !begun.is_number_integer() || !opened.is_number_integer()) return std::nullopt;
  return Header{{item.name, *request, content["bench"], begun.get<std::int64_t>(), false},
                opened.get<std::int64_t>()};
}

/// The image of a cell, as base64.
std::optional<std::string> image_of_cell(const DaemonStore& store, const ExperimentRun& run,
                                         int cell) {
  const auto kept =
      store.find(kind_of(run, Part::picture), name_of(Part::picture, std::size_t(cell)));
  if (!kept || !kept->content.is_object()) return std::nullopt;
  const json base64 = kept->content.value("base64", json());
  if (kept->content.value(kStamp, json()) != run.t_begun_ns || !base64.is_string()) {
    return std::nullopt;
  }
  return base64.get<std::string>();
}

/// All headers, the run opened longest ago first.
Result<std::vector<Header>> headers(DaemonStore& store, const Stop& stop) {
  const auto items = store.load_and_wait(kKind, stop);
  if (!items) return fail(items.error());
  std::vector<Header> all;
  for (const StateItem& item : *items) {
    if (auto header = header_of(item)) all.push_back(std::move(*header));
  }
  std::sort(all.begin(), all.end(),
            [](const Header& a, const Header& b) { return a.t_opened_ns < b.t_opened_ns; });
  return all;
}

struct MeasuredCells {
  std::vector<json> references;  ///< one for each arm; null: not stored
  std::vector<json> cells;       ///< one for each cell, without image pixels; null: not stored
};
/// Results of this execution of the run, identified by t_begun_ns. Ignores files of earlier
/// executions.
Result<MeasuredCells> measured_in(DaemonStore& store, const ExperimentRun& run, const Stop& stop) {
  auto items = store.load_and_wait(kind_of(run), stop);
  if (!items) return fail(items.error());
  MeasuredCells kept{std::vector<json>(run.request.arms.size()),
                     std::vector<json>(run.request.cells())};
  for (StateItem& item : *items) {
    if (!item.content.is_object() || item.content.value(kStamp, json()) != run.t_begun_ns) continue;
    item.content.erase(kStamp);
    const json number = item.content.value("cell", item.content.value("arm", json()));
    if (!number.is_number_unsigned()) continue;
    const auto k = number.get<std::size_t>();
    const auto take = [&](Part part, std::vector<json>& all) {
      if (k < all.size() && item.name == name_of(part, k)) all[k] = std::move(item.content);
    };
    take(Part::cell, kept.cells);
    take(Part::reference, kept.references);
  }
  return kept;
}

/// Writes a file, or leaves it queued. Errors: the file was neither written nor queued.
Result<void> put_file(DaemonStore& store, const std::string& kind, const std::string& name,
                      const json& content, const Stop& stop) {
  const auto kept = store.put_and_wait(kind, name, content, stop);
  if (kept || store.is_queued(kind, name)) return {};
  return fail(kept.error());
}

Result<void> put(DaemonStore& store, const ExperimentRun& run, Part part, int number, json content,
                 const Stop& stop) {
  content[kStamp] = run.t_begun_ns;
  return put_file(store, kind_of(run, part), name_of(part, std::size_t(number)), content, stop);
}

/// Deletes all files of the run but the header.
Result<void> drop_measured(DaemonStore& store, const ExperimentRun& run, const Stop& stop) {
  const auto drop = [&](Part part, std::size_t count) -> Result<void> {
    for (std::size_t k = 0; k < count; ++k) {
      auto dropped = store.drop_and_wait(kind_of(run, part), name_of(part, k), stop);
      if (!dropped) return dropped;
    }
    return {};
  };
  if (auto dropped = drop(Part::reference, run.request.arms.size()); !dropped) return dropped;
  if (auto dropped = drop(Part::cell, run.request.cells()); !dropped) return dropped;
  return drop(Part::picture, run.request.cells());
}

/// Deletes the oldest runs beyond kMaxRuns. The run `current` is kept by name, because it may not
/// look the latest if the clock was set back.
void drop_oldest(DaemonStore& store, const std::string& current, const Stop& stop) {
  auto stored = headers(store, stop);
  if (!stored) return;  // the next run that is opened deletes them
  std::erase_if(*stored, [&current](const Header& one) { return one.run.name == current; });
  for (std::size_t k = 0; k + ExperimentArchive::kMaxRuns <= stored->size(); ++k) {
    // The header is deleted last, so that an interrupted deletion can be continued.
    const ExperimentRun& run = (*stored)[k].run;
    if (drop_measured(store, run, stop)) (void)store.drop_and_wait(kKind, run.name, stop);
  }
}

}  // namespace

ExperimentRun experiment_run(const GainSweepRun& asked, json bench) {
  constexpr std::size_t kNameDigits = 16;
  const std::string all = json_text(json{{"request", to_json(asked.sweep)}, {"bench", bench}});
  return {sha256_hex(all).substr(0, kNameDigits), asked.sweep, std::move(bench), utc_ns(),
          asked.anew};
}

void ExperimentArchive::load() {
  const auto stored = headers(store_, {});
  if (stored && !stored->empty()) (void)read(stored->back().run, {});
}

/// Loads the stored results of the run.
Result<void> ExperimentArchive::read(const ExperimentRun& run, const Stop& stop) {
  auto kept = measured_in(store_, run, stop);
  if (!kept) return fail(kept.error());
  const std::lock_guard lock(mutex_);
  run_ = run;
  references_ = std::move(kept->references);
  cells_ = std::move(kept->cells);
  return {};
}

ExperimentRun ExperimentArchive::current_run() const {
  const std::lock_guard lock(mutex_);
  return *run_;
}

Result<void> ExperimentArchive::open(bool anew, const Stop& stop) {
  if (anew) {
    const std::lock_guard lock(mutex_);
    load_pending_ = false;
  }
  if (auto loaded = load_if_stored(current_run(), stop); !loaded) return loaded;
  const ExperimentRun opened = current_run();
  store_.try_again_and_wait(stop);
  remember_failure(put_file(store_, kKind, opened.name,
                            {{"request", to_json(opened.request)},
                             {"bench", opened.bench},
                             {"t_begun_ns", opened.t_begun_ns},
                             {"t_opened_ns", utc_ns()}},
                            stop));
  if (anew) {
    if (auto dropped = drop_measured(store_, opened, stop); !dropped) return dropped;
  }
  drop_oldest(store_, opened.name, stop);
  return {};
}

/// Loads the stored results of `run` if its header is on the disk. Without a header the results are
/// ignored, because the start time of their execution is unknown.
Result<void> ExperimentArchive::load_if_stored(ExperimentRun run, const Stop& stop) {
  {
    const std::lock_guard lock(mutex_);
    if (!load_pending_) return {};
  }
  const auto stored = headers(store_, stop);
  if (!stored) return fail(stored.error());
  const auto own =
      std::ranges::find(*stored, run.name, [](const Header& one) { return one.run.name; });
  if (own != stored->end()) {
    run.t_begun_ns = own->run.t_begun_ns;
    if (auto loaded = read(run, stop); !loaded) return loaded;
  }
  const std::lock_guard lock(mutex_);
  load_pending_ = false;
  return {};
}

bool ExperimentArchive::remember_failure(const Result<void>& kept) {
  if (kept) return true;
  const std::lock_guard lock(mutex_);
  not_kept_reason_ = kept.error().reason;
  return false;
}

std::optional<std::string> ExperimentArchive::image_in_memory(const ExperimentRun& run,
                                                              int cell) const {
  const std::lock_guard lock(mutex_);
  const auto found = pictures_.find(cell);
  if (run_->name != run.name || found == pictures_.end()) return std::nullopt;
  return found->second;
}

void ExperimentArchive::put_reference(int arm, json reference, const Stop& stop) {
  ExperimentRun run;
  {
    const std::lock_guard lock(mutex_);
    run = *run_;
    references_[std::size_t(arm)] = reference;
  }
  remember_failure(put(store_, run, Part::reference, arm, std::move(reference), stop));
}

/// Writes the cell to disk before it is published, so that a published cell survives a restart.
void ExperimentArchive::put_cell(int cell, json measured, const Stop& stop) {
  const ExperimentRun run = current_run();
  json& picture = measured["picture"];
  if (picture.is_object()) {
    std::string base64 = std::move(picture["base64"].get_ref<std::string&>());
    picture.erase("base64");
    if (!remember_failure(put(store_, run, Part::picture, cell, {{"base64", base64}}, stop))) {
      const std::lock_guard lock(mutex_);
      pictures_[cell] = std::move(base64);
    }
  }
  remember_failure(put(store_, run, Part::cell, cell, measured, stop));
  const std::lock_guard lock(mutex_);
  cells_[std::size_t(cell)] = std::move(measured);
  if (job_) ++job_->done;
}

json ExperimentArchive::reference(int arm) const {
  const std::lock_guard lock(mutex_);
  return references_[std::size_t(arm)];
}

bool ExperimentArchive::has_cell(int cell) const {
  const std::lock_guard lock(mutex_);
  return !cells_[std::size_t(cell)].is_null();
}

void ExperimentArchive::begin_job(const ExperimentRun& run, int job) {
  const std::lock_guard lock(mutex_);
  job_ = Job{run.name, job, monotonic_ns(), 0};
  not_kept_reason_.reset();
  if (run_ && run_->name == run.name && !run.anew) return;
  run_ = run;
  references_.assign(run.request.arms.size(), nullptr);
  cells_.assign(run.request.cells(), nullptr);
  pictures_.clear();
  load_pending_ = true;
}

void ExperimentArchive::end_job() {
  const std::lock_guard lock(mutex_);
  job_.reset();
}

std::optional<int> ExperimentArchive::job_of(const std::string& run) const {
  const std::lock_guard lock(mutex_);
  if (!job_ || job_->run != run) return std::nullopt;
  return job_->number;
}

std::optional<double> ExperimentArchive::time_left_s() const {
  if (!job_ || job_->done == 0) return std::nullopt;
  const auto missing =
      std::count_if(cells_.begin(), cells_.end(), [](const json& cell) { return cell.is_null(); });
  const double passed_s = 1e-9 * double(monotonic_ns() - job_->t_begun_mono_ns);
  return passed_s / job_->done * double(missing);
}

std::optional<std::string> ExperimentArchive::why_not_kept() const {
  if (not_kept_reason_) return not_kept_reason_;
  for (const std::string& kind :
       {std::string(kKind), kind_of(*run_), kind_of(*run_, Part::picture)}) {
    if (auto why = store_.why_queued(kind)) return why;
  }
  return std::nullopt;
}

json ExperimentArchive::result() const {
  const std::lock_guard lock(mutex_);
  if (!run_) return to_json(KnownExperiment{});
  const bool runs = job_ && job_->run == run_->name;
  ExperimentReport report{run_->name,
                          run_->request,
                          {run_->bench},
                          run_->t_begun_ns,
                          runs ? std::optional(job_->number) : std::nullopt,
                          time_left_s(),
                          why_not_kept(),
                          {},
                          {}};
  for (const json& one : references_) {
    if (!one.is_null()) report.references.push_back({one});
  }
  for (const json& one : cells_) {
    if (!one.is_null()) report.cells.push_back({only_fields<CellSummary>(one)});
  }
  return to_json(KnownExperiment{std::move(report), cells_.size()});
}

void ExperimentArchive::cell(int number, std::function<void(Result<json>)> done) {
  std::unique_lock lock(mutex_);
  if (std::size_t(number) >= cells_.size()) {
    const std::string why = cells_.empty() ? "there is no gain sweep: call experiment.gain_sweep"
                                           : fmt::format("there is no cell {}: the last is {}",
                                                         number, cells_.size() - 1);
    lock.unlock();
    return done(fail(Errc::invalid, "cell", why));
  }
  json cell = cells_[std::size_t(number)];
  const ExperimentRun run = *run_;
  lock.unlock();
  if (cell.is_null())
    return done(fail(Errc::refused, "cell",
                     "it has not been measured yet: experiment.get reports the progress"));
  if (!cell["picture"].is_object()) return done(std::move(cell));
  if (auto base64 = image_in_memory(run, number)) {
    cell["picture"]["base64"] = std::move(*base64);
    return done(std::move(cell));
  }
  const auto asked =
      store_.request([&store = store_, run, number, cell = std::move(cell), done]() mutable {
        auto base64 = image_of_cell(store, run, number);
        if (base64) cell["picture"]["base64"] = std::move(*base64);
        if (!base64) cell["picture"] = nullptr;
        done(std::move(cell));
      });
  if (!asked) done(fail(asked.error()));
}

}  // namespace ovws
