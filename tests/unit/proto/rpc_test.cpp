#include "proto/rpc.hpp"

#include <gtest/gtest.h>

#include <stdexcept>
#include <thread>

namespace ovws {
namespace {

/// Test dispatcher: answers "echo" with its params, fails "fail", throws for "throw", keeps "later"
/// for the test.
struct Daemon {
  std::vector<RpcReply> later;
  std::vector<std::string> called;
  std::vector<std::string> sent;
  std::shared_ptr<const std::string> binary;  ///< of the last reply
  Json large;                                 ///< the result of "large"

  void call(const RpcCall& asked, RpcReply reply) {
    const std::string& method = asked.method;
    const Json& params = asked.params;
    called.push_back(method);
    if (method == "echo") return reply(params);
    if (method == "large") return reply(large);
    if (method == "fail") {
      return reply(tl::make_unexpected(
          rpc_failure({Errc::refused, "gain_db", "not while a job runs", 0.0, 24.0, "near"})));
    }
    if (method == "throw") throw std::runtime_error("bad bug");
    if (method == "throw_int") throw 42;
    if (method == "twice") {
      reply(Json(1));
      return reply(Json(2));
    }
    if (method == "binary") {
      return reply(
          RpcResult{params, std::make_shared<const std::string>("<" + asked.binary + ">")});
    }
    if (method == "later") return later.push_back(std::move(reply));
    if (method == "forget") return;
    reply(
        tl::make_unexpected(RpcFailure{RpcCode::method, "unknown method", {{"nearest", "echo"}}}));
  }

  void handle(std::string_view bytes, std::string with_binary = {}) {
    handle_rpc(
        bytes, std::move(with_binary),
        [this](const RpcCall& asked, RpcReply reply) { call(asked, std::move(reply)); },
        [this](std::string reply, std::shared_ptr<const std::string> bytes_after) {
          sent.push_back(std::move(reply));
          binary = std::move(bytes_after);
        });
  }

  /// The only reply, parsed.
  Json answer(std::string_view bytes) {
    sent.clear();
    handle(bytes);
    EXPECT_EQ(sent.size(), 1u);
    return sent.empty() || sent[0].empty() ? Json() : Json::parse(sent[0]);
  }
  int code(std::string_view bytes) { return answer(bytes).at("error").at("code"); }
};

TEST(Rpc, EchoesIdAndGivesTheResult) {
  Daemon d;
  const Json a = d.answer(R"({"jsonrpc":"2.0","method":"echo","params":{"a":1},"id":"x-1"})");
  EXPECT_EQ(a, Json::parse(R"({"jsonrpc":"2.0","id":"x-1","result":{"a":1}})"));
  EXPECT_EQ(d.answer(R"({"jsonrpc":"2.0","method":"echo","id":7})").at("id"), 7);
  EXPECT_EQ(d.answer(R"({"jsonrpc":"2.0","method":"echo","id":-1.5})").at("id"), -1.5);
  EXPECT_EQ(d.answer(R"({"jsonrpc":"2.0","method":"echo","id":null})").at("id"), Json());
  EXPECT_EQ(d.answer(R"({"jsonrpc":"2.0","method":"echo","id":7})").at("result"), Json::object());
}

TEST(Rpc, GivesAnIntegerIdBackToTheLastDigitOrRefusesIt) {
  Daemon d;
  const auto reply = [&d](const std::string& id) {
    d.sent.clear();
    d.handle(R"({"jsonrpc":"2.0","method":"echo","id":)" + id + "}");
    return d.sent.at(0);
  };
  for (const char* id :
       {"0", "-1", "9007199254740993", "9223372036854775807", "9223372036854775808",
        "18446744073709551615", "-9223372036854775808", "1.5", "1e18"}) {
    EXPECT_EQ(Json::parse(reply(id)).at("id"), Json::parse(id)) << id;
    EXPECT_TRUE(Json::parse(reply(id)).contains("result")) << id;
  }
  EXPECT_NE(reply("18446744073709551615").find("\"id\":18446744073709551615,"), std::string::npos);
  d.called.clear();
  for (const char* id : {"18446744073709551616", "-9223372036854775809",
                         "100000000000000000000000000000000000001", "1e300", "-1e19"}) {
    const Json answer = Json::parse(reply(id));
    EXPECT_EQ(answer.at("id"), Json()) << id;
    EXPECT_EQ(answer.at("error").at("code"), -32600) << id;
    EXPECT_EQ(answer.at("error").at("data").at("field"), "id") << id;
  }
  EXPECT_TRUE(d.called.empty());
}

TEST(Rpc, GivesFieldReasonLimitsAndTheNearestName) {
  Daemon d;
  const Json a = d.answer(R"({"jsonrpc":"2.0","method":"fail","id":1})");
  EXPECT_EQ(a.at("error"), Json::parse(R"({"code":-32000,"message":"gain_db: not while a job runs",
    "data":{"field":"gain_db","reason":"not while a job runs","min":0,"max":24,"nearest":"near"}})"));
}

TEST(Rpc, LeavesUnknownMethodsToTheDispatcher) {
  Daemon d;
  EXPECT_EQ(d.code(R"({"jsonrpc":"2.0","method":"eco","id":1})"), -32601);
  EXPECT_EQ(d.called, std::vector<std::string>{"eco"});
}

TEST(Rpc, HasOneCodeForEachReaction) {
  EXPECT_EQ(rpc_code(Errc::invalid), RpcCode::params);
  EXPECT_EQ(rpc_code(Errc::refused), RpcCode::refused);
  EXPECT_EQ(rpc_code(Errc::unavailable), RpcCode::unavailable);
  EXPECT_EQ(rpc_code(Errc::device), RpcCode::device);
  EXPECT_EQ(rpc_code(Errc::internal), RpcCode::internal);
}

TEST(Rpc, RefusesWhatIsNotJson) {
  Daemon d;
  for (std::string_view bytes :
       {"", " ", "{", "nonsense", "{\"jsonrpc\":\"2.0\",}", "{\"a\":1}{\"b\":2}", "{\"a\":NaN}",
        "{\"a\":Infinity}", "{\"a\":1e999}", "'a'", "{\"a\":01}", "// comment\n{}"}) {
    EXPECT_EQ(d.code(bytes), -32700) << bytes;
    EXPECT_EQ(d.answer(bytes).at("id"), Json()) << bytes;
  }
  EXPECT_TRUE(d.called.empty());
}

TEST(Rpc, RefusesWrongUtf8InAndOutsideStrings) {
  Daemon d;
  for (std::string_view bytes :
       {"{\"jsonrpc\":\"2.0\",\"method\":\"\xff\",\"id\":1}", "\xc3\x28", "[\"\xc0\x80\"]",
        "[\"\xed\xa0\x80\"]", "[\"\xf4\x90\x80\x80\"]", "[\"\\ud800\"]", "\xef\xbb"}) {
    EXPECT_EQ(d.code(bytes), -32700);
  }
  using namespace std::string_view_literals;
  EXPECT_EQ(d.code("{\"jsonrpc\":\"2.0\",\0\"id\":1}"sv), -32700);
}

TEST(Rpc, RefusesAMebibyteOfGarbageAtOnce) {
  Daemon d;
  EXPECT_EQ(d.code(std::string(1 << 20, 'x')), -32600);
  EXPECT_EQ(d.code(std::string(kMaxRequestBytes + 1, ' ')), -32600);
  EXPECT_EQ(d.code(std::string(kMaxRequestBytes, 'x')), -32700);
}

TEST(Rpc, RefusesDeepNestingBeforeBuildingIt) {
  Daemon d;
  EXPECT_EQ(d.code(std::string(60000, '[')), -32600);
  std::string deep = R"({"jsonrpc":"2.0","method":"echo","id":1,"params":{"a":)";
  const auto nested = [&deep](int levels) {
    return deep + std::string(levels, '[') + std::string(levels, ']') + "}}";
  };
  EXPECT_EQ(d.code(nested(20000)), -32600);
  EXPECT_EQ(d.code(nested(kMaxRequestDepth - 1)), -32600);
  EXPECT_TRUE(d.answer(nested(kMaxRequestDepth - 2)).contains("result"));
}

TEST(Rpc, RefusesAKeyGivenTwice) {
  Daemon d;
  EXPECT_EQ(d.code(R"({"jsonrpc":"2.0","method":"echo","id":1,"id":2})"), -32600);
  EXPECT_EQ(d.code(R"({"jsonrpc":"2.0","method":"echo","id":1,"params":{"a":1,"a":2}})"), -32600);
  EXPECT_TRUE(d.answer(R"({"jsonrpc":"2.0","method":"echo","id":1,"params":{"a":{"a":2}}})")
                  .contains("result"));
}

TEST(Rpc, RefusesWhatIsNotARequestAndEchoesTheIdItCouldRead) {
  Daemon d;
  for (std::string_view bytes :
       {"1", "null", "\"x\"", "{}", R"({"method":"echo","id":1})",
        R"({"jsonrpc":2.0,"method":"echo","id":1})", R"({"jsonrpc":"1.0","method":"echo","id":1})",
        R"({"jsonrpc":"2.0","id":1})", R"({"jsonrpc":"2.0","method":5,"id":1})",
        R"({"jsonrpc":"2.0","method":"echo","id":[1]})",
        R"({"jsonrpc":"2.0","method":"echo","id":true})",
        R"({"jsonrpc":"2.0","method":"echo","id":1,"parms":{}})"}) {
    EXPECT_EQ(d.code(bytes), -32600) << bytes;
  }
  EXPECT_EQ(d.answer(R"({"jsonrpc":"2.0","method":5,"id":9})").at("id"), 9);
  const Json a = d.answer(R"({"jsonrpc":"2.0","method":"echo","id":1,"parms":{}})");
  EXPECT_EQ(a.at("error").at("data").at("nearest"), "params");
  EXPECT_TRUE(d.called.empty());
}

TEST(Rpc, RefusesParamsThatAreNotAnObject) {
  Daemon d;
  EXPECT_EQ(d.code(R"({"jsonrpc":"2.0","method":"echo","params":[1],"id":1})"), -32602);
  EXPECT_EQ(d.code(R"({"jsonrpc":"2.0","method":"echo","params":null,"id":1})"), -32602);
  EXPECT_EQ(d.code(R"({"jsonrpc":"2.0","method":"echo","params":"a","id":1})"), -32602);
  EXPECT_TRUE(d.called.empty());
}

TEST(Rpc, GivesNotificationsNoResponse) {
  Daemon d;
  d.handle(R"({"jsonrpc":"2.0","method":"echo"})");
  d.handle(R"({"jsonrpc":"2.0","method":"throw"})");
  d.handle(R"([{"jsonrpc":"2.0","method":"echo"},{"jsonrpc":"2.0","method":"fail"}])");
  EXPECT_EQ(d.sent, std::vector<std::string>(3));
  EXPECT_EQ(d.called.size(), 4u);
}

TEST(Rpc, ABadMemberOfABatchFailsAlone) {
  Daemon d;
  const Json a = d.answer(R"([
    {"jsonrpc":"2.0","method":"echo","id":1}, 5, {"jsonrpc":"2.0","method":"echo","params":[],"id":2},
    {"jsonrpc":"2.0","method":"echo"}, {"jsonrpc":"2.0","method":"throw","id":3},
    {"jsonrpc":"2.0","method":"echo","params":{"a":2},"id":4}])");
  ASSERT_EQ(a.size(), 5u);
  EXPECT_TRUE(a[0].contains("result"));
  EXPECT_EQ(a[1].at("error").at("code"), -32600);
  EXPECT_EQ(a[1].at("id"), Json());
  EXPECT_EQ(a[2].at("error").at("code"), -32602);
  EXPECT_EQ(a[3].at("error").at("code"), -32603);
  EXPECT_EQ(a[3].at("id"), 3);
  EXPECT_EQ(a[4].at("result").at("a"), 2);
}

TEST(Rpc, AnswersEachOfTwoRequestsWithOneId) {
  Daemon d;
  const Json a = d.answer(R"([{"jsonrpc":"2.0","method":"echo","params":{"a":1},"id":1},
                              {"jsonrpc":"2.0","method":"echo","params":{"a":2},"id":1}])");
  ASSERT_EQ(a.size(), 2u);
  EXPECT_EQ(a[0].at("result").at("a"), 1);
  EXPECT_EQ(a[1].at("result").at("a"), 2);
}

TEST(Rpc, RefusesEmptyAndHugeBatchesWithOneError) {
  Daemon d;
  EXPECT_EQ(d.code("[]"), -32600);
  std::string many = "[1";
  for (int k = 0; k < kMaxBatchMembers; ++k) many += ",1";
  EXPECT_EQ(d.code(many + "]"), -32600);
}

TEST(Rpc, RefusesMembersOfABatchBeyondTheLimitOfItsReplyWithoutACall) {
  Daemon d;
  d.large = Json(std::string(kMaxBatchReplyBytes / 2, 'x'));
  const Json a = d.answer(R"([{"jsonrpc":"2.0","method":"large","id":1},
      {"jsonrpc":"2.0","method":"large","id":2}, {"jsonrpc":"2.0","method":"echo","id":3},
      {"jsonrpc":"2.0","method":"echo"}, {"jsonrpc":"2.0","method":5,"id":4}])");
  ASSERT_EQ(a.size(), 4u);
  EXPECT_TRUE(a[0].contains("result"));
  EXPECT_TRUE(a[1].contains("result"));
  EXPECT_EQ(a[2].at("error").at("code"), -32000);
  EXPECT_EQ(a[2].at("error").at("message"),
            "the batch's reply would be larger than 1 MiB; this request was not carried out; send "
            "it in another batch");
  EXPECT_EQ(a[2].at("id"), 3);
  EXPECT_EQ(a[3].at("error").at("code"), -32600);
  EXPECT_EQ(d.called, (std::vector<std::string>{"large", "large", "echo"}));  // the notification
}

TEST(Rpc, GivesASingleRequestItsReplyWhateverItsSize) {
  Daemon d;
  d.large = Json(std::string(2 * kMaxBatchReplyBytes, 'x'));
  EXPECT_TRUE(d.answer(R"({"jsonrpc":"2.0","method":"large","id":1})").contains("result"));
}

TEST(Rpc, SendsABatchOnceWhenTheLastAnswerIsThere) {
  Daemon d;
  d.handle(R"([{"jsonrpc":"2.0","method":"later","id":1},{"jsonrpc":"2.0","method":"later","id":2},
               {"jsonrpc":"2.0","method":"echo","id":3}])");
  ASSERT_EQ(d.later.size(), 2u);
  EXPECT_TRUE(d.sent.empty());
  std::thread other([&d] { d.later[1](Json("second")); });
  other.join();
  EXPECT_TRUE(d.sent.empty());
  d.later[0](Json("first"));
  ASSERT_EQ(d.sent.size(), 1u);
  const Json a = Json::parse(d.sent[0]);
  EXPECT_EQ(a[0].at("result"), "first");
  EXPECT_EQ(a[1].at("result"), "second");
}

TEST(Rpc, GathersABatchFromManyThreads) {
  for (int round = 0; round < 50; ++round) {
    Daemon d;
    std::string batch;
    for (int k = 0; k < 16; ++k) {
      batch += (k > 0 ? "," : "[") +
               (R"({"jsonrpc":"2.0","method":"later","id":)" + std::to_string(k)) + "}";
    }
    d.handle(batch + "]");
    std::vector<std::thread> threads;
    for (int t = 0; t < 4; ++t) {
      threads.emplace_back([&d, t] {
        for (int k = t; k < 16; k += 4) d.later[k](Json(k));
      });
    }
    for (auto& thread : threads) thread.join();
    ASSERT_EQ(d.sent.size(), 1u);
    const Json a = Json::parse(d.sent[0]);
    for (int k = 0; k < 16; ++k) EXPECT_EQ(a[k].at("result"), k);
  }
}

TEST(Rpc, AnswersOnceEvenIfTheReplyIsCalledTwice) {
  Daemon d;
  EXPECT_EQ(d.answer(R"({"jsonrpc":"2.0","method":"twice","id":1})").at("result"), 1);
}

TEST(Rpc, MakesAThrowingDispatcherAnInternalError) {
  Daemon d;
  const Json a = d.answer(R"({"jsonrpc":"2.0","method":"throw","id":1})");
  EXPECT_EQ(a.at("error").at("code"), -32603);
  EXPECT_EQ(a.at("error").at("message"), "internal error: bad bug");
  EXPECT_EQ(d.code(R"({"jsonrpc":"2.0","method":"throw_int","id":1})"), -32603);
}

TEST(Rpc, MakesAForgottenReplyAnInternalError) {
  Daemon d;
  EXPECT_EQ(d.code(R"({"jsonrpc":"2.0","method":"forget","id":1})"), -32603);
  d.sent.clear();
  d.handle(R"({"jsonrpc":"2.0","method":"later","id":1})");
  EXPECT_TRUE(d.sent.empty());
  d.later.clear();
  ASSERT_EQ(d.sent.size(), 1u);
}

TEST(Rpc, RepliesHoldNeitherNanNorInvalidUtf8) {
  std::string sent;
  handle_rpc(R"({"jsonrpc":"2.0","method":"m","id":1})", {},
             [](const RpcCall&, const RpcReply& reply) {
               reply(RpcResult{{{"nan", std::nan("")}, {"text", "\xff"}}});
             },
             [&sent](std::string bytes, const auto&) { sent = std::move(bytes); });
  const Json a = Json::parse(sent);
  EXPECT_TRUE(a.at("result").at("nan").is_null());
  EXPECT_EQ(a.at("result").at("text"), "\xef\xbf\xbd");
}

TEST(Rpc, PassesBinaryFramesOfSingleRequestsOnly) {
  Daemon d;
  d.handle(R"({"jsonrpc":"2.0","method":"binary","params":{"a":1},"id":1})", "x\0y");
  ASSERT_TRUE(d.binary);
  EXPECT_EQ(*d.binary, "<x>");
  EXPECT_EQ(Json::parse(d.sent.back()).at("result").at("a"), 1);
  d.handle(R"([{"jsonrpc":"2.0","method":"echo","id":1}])", "x");
  EXPECT_FALSE(d.binary);
  EXPECT_EQ(Json::parse(d.sent.back()).at("error").at("code"), -32600);
  d.handle(
      R"([{"jsonrpc":"2.0","method":"binary","id":1},{"jsonrpc":"2.0","method":"echo","id":2}])");
  EXPECT_FALSE(d.binary);
  EXPECT_EQ(Json::parse(d.sent.back())[0].at("error").at("code"), -32000);
  EXPECT_TRUE(Json::parse(d.sent.back())[1].contains("result"));
}

}  // namespace
}  // namespace ovws
