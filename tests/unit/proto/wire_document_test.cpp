#include <gtest/gtest.h>

#include <fstream>
#include <regex>
#include <set>

#include "core/rt/counters.hpp"
#include "proto/requests.hpp"
#include "proto/rpc.hpp"
#include "proto/tables/loop.hpp"
#include "proto/tables/modes.hpp"

namespace ovws {
namespace {

/// The JSON-RPC lines of WIRE.md's json blocks.
std::vector<Json> rpc_lines() {
  std::ifstream file(OVWS_SOURCE_DIR "/proto/WIRE.md");
  std::vector<Json> lines;
  bool inside = false;
  for (std::string line; std::getline(file, line);) {
    if (line.rfind("```", 0) == 0) {
      inside = line == "```json";
    } else if (inside) {
      Json message = Json::parse(line);
      if (message.contains("jsonrpc")) lines.push_back(std::move(message));
    }
  }
  return lines;
}

template <class T>
RpcAnswer refusal_or_nothing(const Result<T>& decoded) {
  if (!decoded) return tl::make_unexpected(rpc_failure(decoded.error()));
  return Json();
}

RpcAnswer answer(const std::string& method, const Json& params) {
  if (method == "camera.set") return refusal_or_nothing(CameraSet::decode(params));
  if (method == "reference.take") return refusal_or_nothing(decode<ReferenceTake>(params));
  if (method == "job.get") return refusal_or_nothing(decode<JobNumber>(params));
  const auto modes = ModesSet::decode(params);
  if (!modes) return refusal_or_nothing(modes);
  return to_json(AberrationReport(modes->modes, {}, 9));
}

std::string text_of_source(const std::string& path) {
  std::ifstream file(OVWS_SOURCE_DIR "/" + path);
  return {std::istreambuf_iterator<char>(file), {}};
}

TEST(WireDocument, SaysHowARequestedOpeningOfTheLoopIsReported) {
  const std::string text = LoopReport::kOpenedOnRequest;
  EXPECT_NE(text_of_source("proto/WIRE.md").find("`" + text + "`"), std::string::npos);
  EXPECT_NE(text_of_source("daemon/web/page/bar.js").find("\"" + text + "\""), std::string::npos)
      << "the page does not call it an opening by itself";
}

TEST(WireDocument, ShowsRepliesAsTheyAreGiven) {
  const auto lines = rpc_lines();
  ASSERT_GE(lines.size(), 12u);
  for (std::size_t k = 0; k + 1 < lines.size(); k += 2) {
    Json reply;
    handle_rpc(
        lines[k].dump(), {},
        [](const RpcCall& call, const RpcReply& give) { give(answer(call.method, call.params)); },
        [&reply](const std::string& bytes, const auto&) { reply = Json::parse(bytes); });
    EXPECT_EQ(reply.contains("error"), lines[k + 1].contains("error")) << lines[k];
    if (reply.contains("error") || !reply.at("result").is_null()) {
      EXPECT_EQ(reply, lines[k + 1]);
    }
  }
}

using Names = std::set<std::string>;

/// The names in the first column of WIRE.md's table of counters.
Names documented_counters() {
  std::ifstream file(OVWS_SOURCE_DIR "/proto/WIRE.md");
  Names names;
  bool inside = false;
  const std::regex name("`([a-z_]+)`");
  for (std::string line; std::getline(file, line);) {
    if (line == "| counter | counts |") {
      inside = true;
    } else if (line.empty()) {
      inside = false;
    }
    if (!inside) continue;
    const std::string column = line.substr(0, line.find('|', 1));
    for (std::sregex_iterator it(column.begin(), column.end(), name), end; it != end; ++it) {
      names.insert((*it)[1]);
    }
  }
  return names;
}

TEST(WireDocument, NamesTheCountersThatThereAre) {
  Names names;
  for (std::size_t k = 0; k < std::size_t(Counter::count_); ++k) {
    names.emplace(counter_name(Counter(k)));
  }
  EXPECT_EQ(documented_counters(), names);
}

}  // namespace
}  // namespace ovws
