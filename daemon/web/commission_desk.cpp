#include "daemon/web/commission_desk.hpp"

#include "proto/json_text.hpp"
#include "proto/strict_json.hpp"

namespace ovws::web {
namespace {

using nlohmann::json;

constexpr int kMaxRequestDepth = 4;

json error_json(const Error& error) {
  return {{"error", cli::failure(error).error}};
}

}  // namespace

std::shared_ptr<commission::Commissioning> CommissionDesk::commissioning() {
  const std::scoped_lock lock(mutex_);
  if (!commissioning_ && !ended_) {
    commission::Settings settings;
    settings.daemon = daemon_;
    commissioning_ = std::make_shared<commission::Commissioning>(std::move(settings));
  }
  return commissioning_;
}

std::string CommissionDesk::report(Right right) {
  const auto now = commissioning();
  if (!now) return "null";
  json report = to_json(now->report());
  report["right"] = right == Right::control ? "control" : "look";
  return json_text(report);
}

tl::expected<std::string, Refusal> CommissionDesk::act(const std::string& body) {
  const auto request = parse_strict_json(body, kMaxRequestDepth, JsonComments::refused);
  if (!request || !request->is_object()) return tl::make_unexpected(Refusal::malformed);
  for (const auto& [key, value] : request->items()) {
    const bool is_known = key == "action" || key == "step" || key == "offer";
    if (!is_known || !value.is_string()) return tl::make_unexpected(Refusal::malformed);
  }
  const auto now = commissioning();
  if (!now) return json_text(error_json({Errc::unavailable, "", "ovws-web is stopping"}));
  const auto text = [&](const char* key) { return request->value(key, std::string()); };
  const auto done = now->act(text("action"), text("step"), text("offer"));
  if (!done) return json_text(error_json(done.error()));
  return json_text({{"result", to_json(now->report())}});
}

std::string CommissionDesk::picture(std::string_view step) {
  const auto now = commissioning();
  if (!now) return {};
  auto png = now->picture_png(step);
  return png ? std::move(*png) : std::string();
}

void CommissionDesk::end() {
  std::shared_ptr<commission::Commissioning> last;
  {
    const std::scoped_lock lock(mutex_);
    ended_ = true;
    last = std::move(commissioning_);
  }
}

}  // namespace ovws::web
