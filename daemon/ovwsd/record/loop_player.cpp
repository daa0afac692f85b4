#include "daemon/ovwsd/record/loop_player.hpp"

#include <exception>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <utility>
#include <vector>

#include "core/control/loop_laws.hpp"
#include "daemon/ovwsd/record/point_document.hpp"
#include "proto/json_text.hpp"
#include "proto/tables/loop.hpp"

namespace ovws {
namespace {

using nlohmann::json;

std::shared_ptr<const LoopModel> model_of(const json& modes) {
  if (modes.is_null()) return nullptr;
  return std::make_shared<LoopModel>(decode<LoopModel>({{"modes", modes}}).value());
}

/// Repeats one recording's runs, document by document. Its functions throw if a document has other
/// content than loop_log.cpp and plan_facts.cpp write.
class LoopPlayer {
 public:
  explicit LoopPlayer(RecordingReader& reader) : reader_(reader) {}

  void add_plan(const json& plan) {
    Plan& one = plans_[plan.at("plan_id").get<std::uint64_t>()];
    one.modes_j = plan.at("modes_j").get<std::vector<int>>();
    one.correction = modes_from(plan.at("correction"));
    corrections_[plan.at("hologram_id").get<std::uint64_t>()] = one.correction;
  }
  void begin(const json& loop) {
    t_closed_ns_ = loop.at("t_closed_ns").get<std::int64_t>();
    auto settings = decode<LoopSettings>(loop.at("settings")).value();
    auto laws = laws_of(settings, model_of(loop.at("model")));
    control_.emplace(std::move(settings), modes_from(loop.at("correction")), std::move(laws));
    ++played_.runs;
  }
  void repeat(const json& steps) {
    if (!control_ || steps.at("t_closed_ns").get<std::int64_t>() != t_closed_ns_) {
      control_.reset();
      return stop("the loop was closed before the recording began");
    }
    for (const json& frame : steps.at("frames")) {
      if (!control_) return;
      repeat_frame(frame);
    }
  }
  /// The rest cannot be repeated.
  void stop(const std::string& reason) {
    if (played_.reason.empty()) played_.reason = reason;
    control_.reset();
  }
  PlayedLoop played() const { return played_; }

 private:
  struct Plan {
    std::vector<int> modes_j;
    std::vector<Mode> correction;
  };

  const RecordedFrame* find(std::uint64_t frame_id) {
    const auto& all = reader_.frames();
    for (std::size_t k = next_frame_; k < all.size(); ++k) {
      if (all[k].frame_id != frame_id) continue;
      next_frame_ = k + 1;
      return &all[k];
    }
    return nullptr;
  }

  void repeat_frame(const json& row) {
    const auto id = row.at(0).get<std::uint64_t>();
    const RecordedFrame* const frame = find(id);
    if (frame == nullptr) return stop("frame " + std::to_string(id) + " is not in the recording");
    const auto plan = plans_.find(frame->plan_id);
    if (plan == plans_.end()) {
      return stop("the plan of frame " + std::to_string(id) + " is not in the recording");
    }
    observe(*frame, row.at(1).get<std::int64_t>(), plan->second);
    if (!control_ || row.size() < 4) return;  // what cannot be observed ends the run
    control_->step(row.at(2).get<std::int64_t>());
    const auto shown = corrections_.find(row.at(3).get<std::uint64_t>());
    if (shown == corrections_.end()) return;  // no frame of that hologram was recorded
    ++played_.decisions;
    if (control_->correction() == shown->second) {
      ++played_.same;
    } else if (played_.first_difference.empty()) {
      played_.first_difference = "frame " + std::to_string(id);
    }
  }

  void observe(const RecordedFrame& frame, std::int64_t t_ns, const Plan& plan) {
    const std::vector<float> waves = reader_.coefficients(frame).value();
    const std::vector<float> sigma_waves = reader_.sigma_waves(frame).value();
    const std::size_t count = waves.size();
    if (plan.modes_j.size() < count || sigma_waves.size() != count) {
      return stop("frame " + std::to_string(frame.frame_id) + " has other modes than its plan");
    }
    control_->observe({t_ns, std::span(plan.modes_j).first(count), waves, sigma_waves},
                      plan.correction);
  }

  RecordingReader& reader_;
  std::map<std::uint64_t, Plan> plans_;                     ///< by number
  std::map<std::uint64_t, std::vector<Mode>> corrections_;  ///< by hologram
  std::optional<ModalControl> control_;                     ///< of the present run
  std::int64_t t_closed_ns_ = 0;
  std::size_t next_frame_ = 0;
  PlayedLoop played_;
};

}  // namespace

Result<PlayedLoop> replay_loop(RecordingReader& reader) {
  auto documents = reader.documents();
  if (!documents) return fail(documents.error());
  try {
    LoopPlayer player(reader);
    for (const auto& one : *documents) {
      if (one.kind == "plan") player.add_plan(json_of(one.text));
    }
    for (const auto& one : *documents) {
      if (one.kind == "loop") player.begin(json_of(one.text));
      if (one.kind == "loop_steps") player.repeat(json_of(one.text));
      if (one.kind == "loop_cut") {
        player.stop("documents of the loop are not in the recording: the disk was too slow");
      }
    }
    return player.played();
  } catch (const std::exception& error) {  // also of a Result without a value
    return fail(Errc::invalid, "path",
                "the recording's documents of the loop are damaged; use an intact copy");
  }
}

}  // namespace ovws
