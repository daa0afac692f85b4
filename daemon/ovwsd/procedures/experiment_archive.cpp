#include "daemon/ovwsd/procedures/experiment_archive.hpp"

#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <utility>

#include "core/port/clock.hpp"

namespace ovws {

using nlohmann::json;
using Part = ExperimentFiles::Part;

void ExperimentArchive::load() {
  if (const auto run = files_.latest()) read(*run);
}

/// Loads the stored results of the run.
void ExperimentArchive::read(const ExperimentRun& run) {
  auto kept = files_.measured(run);
  const std::lock_guard lock(mutex_);
  run_ = run;
  references_ = std::move(kept.references);
  cells_ = std::move(kept.cells);
}

ExperimentRun ExperimentArchive::current_run() const {
  const std::lock_guard lock(mutex_);
  return *run_;
}

Result<void> ExperimentArchive::open(bool anew) {
  if (anew) {
    const std::lock_guard lock(mutex_);
    load_pending_ = false;
  }
  load_if_stored(current_run());
  const ExperimentRun opened = current_run();
  files_.try_again();
  remember_failure(files_.put_header(opened));
  if (anew) {
    if (auto dropped = files_.drop_measured(opened); !dropped) return dropped;
  }
  files_.drop_oldest(opened.name);
  return {};
}

/// Ignores files without a header: they are left over from a run whose deletion was interrupted.
void ExperimentArchive::load_if_stored(ExperimentRun run) {
  {
    const std::lock_guard lock(mutex_);
    if (!std::exchange(load_pending_, false)) return;
  }
  const auto stored = files_.find(run.name);
  if (!stored) return;
  run.t_begun_ns = stored->t_begun_ns;
  read(run);
}

bool ExperimentArchive::remember_failure(const Result<void>& kept) {
  if (kept) return true;
  const std::lock_guard lock(mutex_);
  not_kept_reason_ = kept.error().reason;
  return false;
}

std::optional<std::string> ExperimentArchive::picture_in_memory(const ExperimentRun& run,
                                                                int cell) const {
  const std::lock_guard lock(mutex_);
  const auto found = pictures_.find(cell);
  if (run_->name != run.name || found == pictures_.end()) return std::nullopt;
  return found->second;
}

void ExperimentArchive::put_reference(int arm, json reference) {
  ExperimentRun run;
  {
    const std::lock_guard lock(mutex_);
    run = *run_;
    references_[std::size_t(arm)] = reference;
  }
  remember_failure(files_.put(run, Part::reference, arm, std::move(reference)));
}

/// Writes the cell to disk before publishing it, so that a published cell survives a restart.
void ExperimentArchive::put_cell(int cell, json measured) {
  const ExperimentRun run = current_run();
  json& picture = measured["picture"];
  if (picture.is_object()) {
    std::string base64 = std::move(picture["base64"].get_ref<std::string&>());
    picture.erase("base64");
    if (!remember_failure(files_.put(run, Part::picture, cell, {{"base64", base64}}))) {
      const std::lock_guard lock(mutex_);
      pictures_[cell] = std::move(base64);
    }
  }
  remember_failure(files_.put(run, Part::cell, cell, measured));
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
  return files_.why_not_kept(*run_);
}

json ExperimentArchive::result() const {
  const std::lock_guard lock(mutex_);
  if (!run_) return to_json(KnownExperiment{});
  const bool runs = job_ && job_->run == run_->name;
  ExperimentReport report{run_->name,
                          run_->request,
                          run_->bench,
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
                     "it has not been measured yet: experiment.get tells the progress"));
  if (!cell["picture"].is_object()) return done(std::move(cell));
  if (auto base64 = picture_in_memory(run, number)) {
    cell["picture"]["base64"] = std::move(*base64);
    return done(std::move(cell));
  }
  const auto with = [cell = std::move(cell), done](std::optional<std::string> base64) mutable {
    if (base64) cell["picture"]["base64"] = std::move(*base64);
    if (!base64) cell["picture"] = nullptr;
    done(std::move(cell));
  };
  if (auto asked = files_.request_picture(run, number, with); !asked) done(fail(asked.error()));
}

}  // namespace ovws
