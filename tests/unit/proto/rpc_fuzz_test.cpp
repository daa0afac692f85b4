#include <gtest/gtest.h>

#include <random>

#include "proto/rpc.hpp"
#include "tests/support/decode_all.hpp"

namespace ovws {
namespace {

constexpr int kInputs = 20000;

const std::vector<std::string>& seeds() {
  static const std::vector<std::string> texts{
      R"({"jsonrpc":"2.0","method":"camera.set","params":{"gain_db":12.5,"roi":{"x":0,"y":1,"width":64,"height":64},"clamp":true},"id":1})",
      R"({"jsonrpc":"2.0","method":"sensor.set","params":{"charge":-1,"grooves":[200,20],"tracker":"lg"},"id":"a"})",
      R"({"jsonrpc":"2.0","method":"aberration.set","params":{"modes":[{"n":2,"m":-2,"waves":0.5},{"j":12,"waves":1e-3}],"norm":"unit"},"id":null})",
      R"([{"jsonrpc":"2.0","method":"job.get","params":{"job":3},"id":1},{"jsonrpc":"2.0","method":"slm.show","params":{"pattern":"flat"}}])"};
  return texts;
}

/// Mutated request: some bytes changed, removed, doubled or truncated, or random bytes.
std::string input(std::mt19937& random) {
  const auto below = [&random](std::size_t n) { return std::size_t(random() % n); };
  if (below(10) == 0) {
    std::string bytes(below(200), '\0');
    for (char& c : bytes) c = char(random());
    return bytes;
  }
  static const std::string kTokens = "{}[]\",:0123456789-+.eEtruefalsnu\\/ \n\xff\x80\xc3";
  std::string text = seeds()[below(seeds().size())];
  for (std::size_t edits = below(4); edits > 0 && !text.empty(); --edits) {
    const std::size_t at = below(text.size());
    switch (below(4)) {
      case 0:
        text[at] = kTokens[below(kTokens.size())];
        break;
      case 1:
        text.erase(at, 1 + below(6));
        break;
      case 2:
        text.insert(at, text.substr(at, below(20)));
        break;
      default:
        text.insert(at, 1, kTokens[below(kTokens.size())]);
        break;
    }
  }
  return text;
}

std::size_t responses_wanted(const Json& frame) {
  if (!frame.is_array() || frame.empty()) return 1;
  std::size_t count = 0;
  for (const Json& member : frame) {
    const bool notification =
        member.is_object() && !member.contains("id") && member.value("jsonrpc", Json()) == "2.0" &&
        member.value("method", Json()).is_string() && member.size() == 2 + member.count("params");
    count += notification ? 0 : 1;
  }
  return count;
}

TEST(RpcFuzz, NeverThrowsAndAnswersEveryRequestOnce) {
  std::mt19937 random(20260101);
  int answered = 0, results = 0;
  for (int k = 0; k < kInputs; ++k) {
    const std::string bytes = input(random);
    std::vector<std::string> sent;
    ASSERT_NO_THROW(handle_rpc(
        bytes, {},
        [&results](const RpcCall& call, const RpcReply& reply) {
          test::decode_all(call.params);
          ++results;
          reply(RpcResult{call.params});
        },
        [&sent](std::string reply, const auto&) { sent.push_back(std::move(reply)); }))
        << bytes;
    ASSERT_EQ(sent.size(), 1u) << bytes;
    const Json parsed = Json::parse(bytes, nullptr, false);
    if (parsed.is_array() && !parsed.empty() && sent[0].empty()) {
      ASSERT_EQ(responses_wanted(parsed), 0u) << bytes;
    }
    if (sent[0].empty()) continue;
    const Json reply = Json::parse(sent[0]);
    if (reply.is_array()) {
      ASSERT_EQ(reply.size(), responses_wanted(parsed)) << bytes;
    }
    ++answered;
  }
  EXPECT_GT(answered, kInputs / 2);
  EXPECT_GT(results, kInputs / 10);  // enough inputs were valid enough to reach the decoders
}

}  // namespace
}  // namespace ovws
