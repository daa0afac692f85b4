#include "daemon/experiment_archive.hpp"

#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <utility>

#include "core/port/clock.hpp"
#include "daemon/store/encoding.hpp"

namespace ovws {
namespace {

using nlohmann::json;

constexpr const char* kKind = "experiment";
constexpr std::size_t kNameDigits = 16;

std::string kind_of(const std::string& run) {
  return std::string(kKind) + "-" + run;
}

/// Of which measuring of a run a file is: `anew` leaves none of before behind, even if a file of it
/// stays.
constexpr const char* kStamp = "run_t_begun_ns";

/// Of their own kind: many megabytes each, and read only when one is asked for.
std::string picture_kind_of(const std::string& run) {
  return std::string(kKind) + "-picture-" + run;
}

std::string reference_name(std::size_t arm) {
  return fmt::format("reference-{:02}", arm);
}

std::string cell_name(std::size_t cell) {
  return fmt::format("cell-{:05}", cell);
}

std::string picture_name(std::size_t cell) {
  return fmt::format("picture-{:05}", cell);
}

/// None: it is not of this program.
struct Header {
  ExperimentRun run;
  std::int64_t t_opened_ns = 0;
};
std::optional<Header> header_of(const StateItem& item) {
  const json& content = item.content;
  if (!content.is_object() || !content.contains("request") || !content.contains("bench")) {
    return std::nullopt;
  }
  const auto request = decode_gain_sweep(content["request"]);
  const json begun = content.value("t_begun_ns", json()),
             opened = content.value("t_opened_ns", json());
  if (!request || !begun.is_number_integer() || !opened.is_number_integer()) return std::nullopt;
  return Header{{item.name, *request, content["bench"], begun.get<std::int64_t>()},
                opened.get<std::int64_t>()};
}

json header_json(const ExperimentRun& run) {
  return {{"request", to_json(run.request)},
          {"bench", run.bench},
          {"t_begun_ns", run.t_begun_ns},
          {"t_opened_ns", utc_ns()}};
}

/// Oldest first, by when they were asked for last.
std::vector<Header> headers(const DaemonStore& store) {
  std::vector<Header> all;
  store.load(kKind, [&all](const StateItem& item) {
    if (auto header = header_of(item)) all.push_back(std::move(*header));
  });
  std::sort(all.begin(), all.end(),
            [](const Header& a, const Header& b) { return a.t_opened_ns < b.t_opened_ns; });
  return all;
}

}  // namespace

ExperimentRun experiment_run(const GainSweep& request, json bench) {
  const std::string all = json{{"request", to_json(request)}, {"bench", bench}}.dump();
  return {sha256_hex(all).substr(0, kNameDigits), request, std::move(bench), utc_ns()};
}

void ExperimentArchive::load() {
  const auto known = headers(store_);
  if (!known.empty()) read(known.back().run);
}

/// What is there of the run.
void ExperimentArchive::read(const ExperimentRun& run) {
  std::vector<json> references(run.request.arms.size()), cells(run.request.cells());
  store_.load(kind_of(run.name), [&](StateItem item) {
    if (!item.content.is_object() || item.content.value(kStamp, json()) != run.t_begun_ns) return;
    item.content.erase(kStamp);
    const json number = item.content.value("cell", item.content.value("arm", json()));
    if (!number.is_number_unsigned()) return;
    const auto k = number.get<std::size_t>();
    if (k < cells.size() && item.name == cell_name(k)) cells[k] = std::move(item.content);
    if (k < references.size() && item.name == reference_name(k)) {
      references[k] = std::move(item.content);
    }
  });
  const std::lock_guard lock(mutex_);
  run_ = run;
  references_ = std::move(references);
  cells_ = std::move(cells);
}

Result<void> ExperimentArchive::open(bool anew) {
  ExperimentRun opened;
  {
    const std::lock_guard lock(mutex_);
    opened = *run_;
    if (anew) to_read_ = false;
  }
  read_if_known(opened);
  {
    const std::lock_guard lock(mutex_);
    opened = *run_;
  }
  put(kKind, opened.name, header_json(opened));
  if (anew) {
    if (auto dropped = drop_measured(opened); !dropped) return dropped;
  }
  drop_oldest(opened.name);
  return {};
}

/// Files without a header are what a kill left of a run that was being removed.
void ExperimentArchive::read_if_known(ExperimentRun run) {
  {
    const std::lock_guard lock(mutex_);
    if (!std::exchange(to_read_, false)) return;
  }
  for (const Header& known : headers(store_)) {
    if (known.run.name != run.name) continue;
    run.t_begun_ns = known.run.t_begun_ns;
    return read(run);
  }
}

Result<void> ExperimentArchive::drop_measured(const ExperimentRun& run) {
  const std::string kind = kind_of(run.name), pictures = picture_kind_of(run.name);
  for (std::size_t k = 0; k < run.request.arms.size(); ++k) {
    if (auto dropped = store_.drop(kind, reference_name(k)); !dropped) return dropped;
  }
  for (std::size_t k = 0; k < run.request.cells(); ++k) {
    if (auto dropped = store_.drop(kind, cell_name(k)); !dropped) return dropped;
    if (auto dropped = store_.drop(pictures, picture_name(k)); !dropped) return dropped;
  }
  return {};
}

/// The time of day may have been set back: the run that is open need not seem the latest.
void ExperimentArchive::drop_oldest(const std::string& current) {
  auto known = headers(store_);
  std::erase_if(known, [&current](const Header& one) { return one.run.name == current; });
  for (std::size_t k = 0; k + kMostKept <= known.size(); ++k) {
    // The header last: with it the rest is found again after a kill, or when a file stays.
    if (drop_measured(known[k].run)) (void)store_.drop(kKind, known[k].run.name);
  }
}

bool ExperimentArchive::put(const std::string& kind, const std::string& name, const json& content) {
  const auto kept = store_.put(kind, name, content);
  const std::lock_guard lock(mutex_);
  if (!kept) not_kept_reason_ = kept.error().reason;
  return bool(kept);
}

void ExperimentArchive::put_picture(const ExperimentRun& run, int cell, std::string base64) {
  const bool kept = put(picture_kind_of(run.name), picture_name(std::size_t(cell)),
                        {{kStamp, run.t_begun_ns}, {"base64", base64}});
  const std::lock_guard lock(mutex_);
  if (!kept) pictures_not_kept_[cell] = std::move(base64);
}

std::optional<std::string> ExperimentArchive::picture_of(const ExperimentRun& run, int cell) const {
  {
    const std::lock_guard lock(mutex_);
    const auto found = pictures_not_kept_.find(cell);
    if (run_->name == run.name && found != pictures_not_kept_.end()) return found->second;
  }
  auto kept = store_.find(picture_kind_of(run.name), picture_name(std::size_t(cell)));
  if (!kept || !kept->content.is_object()) return std::nullopt;
  const json base64 = kept->content.value("base64", json());
  if (kept->content.value(kStamp, json()) != run.t_begun_ns || !base64.is_string()) {
    return std::nullopt;
  }
  return base64.get<std::string>();
}

void ExperimentArchive::put_reference(int arm, json reference) {
  std::string kind;
  json kept = reference;
  {
    const std::lock_guard lock(mutex_);
    kind = kind_of(run_->name);
    kept[kStamp] = run_->t_begun_ns;
    references_[std::size_t(arm)] = std::move(reference);
  }
  put(kind, reference_name(std::size_t(arm)), kept);
}

/// Kept before it is told: who was told of a cell finds it again.
void ExperimentArchive::put_cell(int cell, json measured) {
  ExperimentRun run;
  {
    const std::lock_guard lock(mutex_);
    run = *run_;
  }
  json& picture = measured["picture"];
  if (picture.is_object()) {
    put_picture(run, cell, std::move(picture["base64"].get_ref<std::string&>()));
    picture.erase("base64");
  }
  json kept = measured;
  kept[kStamp] = run.t_begun_ns;
  put(kind_of(run.name), cell_name(std::size_t(cell)), kept);
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
  if (run_ && run_->name == run.name && !run.request.anew) return;
  run_ = run;
  references_.assign(run.request.arms.size(), nullptr);
  cells_.assign(run.request.cells(), nullptr);
  pictures_not_kept_.clear();
  not_kept_reason_.reset();
  to_read_ = true;
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

json ExperimentArchive::result() const {
  const std::lock_guard lock(mutex_);
  if (!run_) return experiment_result(nullptr);
  const bool runs = job_ && job_->run == run_->name;
  const ExperimentReport report{run_->name,
                                run_->request,
                                run_->bench,
                                run_->t_begun_ns,
                                runs ? std::optional(job_->number) : std::nullopt,
                                time_left_s(),
                                not_kept_reason_,
                                references_,
                                cells_};
  return experiment_result(&report);
}

Result<json> ExperimentArchive::cell(int number) const {
  std::unique_lock lock(mutex_);
  if (std::size_t(number) >= cells_.size()) {
    return fail(Errc::invalid, "cell",
                cells_.empty() ? "there is no gain sweep: call experiment.gain_sweep"
                               : fmt::format("there is no cell {}: the last is {}", number,
                                             cells_.size() - 1));
  }
  json cell = cells_[std::size_t(number)];
  if (cell.is_null()) return fail(Errc::refused, "cell", "it was not measured yet");
  if (!cell["picture"].is_object()) return cell;
  const ExperimentRun run = *run_;
  lock.unlock();
  if (auto base64 = picture_of(run, number)) {
    cell["picture"]["base64"] = std::move(*base64);
  } else {
    cell["picture"] = nullptr;
  }
  return cell;
}

}  // namespace ovws
