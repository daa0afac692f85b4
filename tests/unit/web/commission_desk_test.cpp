/// The commissioning that browsers share, without a daemon.
#include "daemon/web/commission_desk.hpp"

#include <gtest/gtest.h>

namespace ovws::web {
namespace {

/// A desk whose daemon never answers.
class Desk : public testing::Test {
 protected:
  static cli::Common nobody() {
    cli::Common common;
    common.endpoint = "tcp://127.0.0.1:1";
    common.timeout_s = 0.05;
    return common;
  }
  nlohmann::json act(const std::string& body) { return nlohmann::json::parse(*desk_.act(body)); }
  CommissionDesk desk_{nobody()};
};

TEST_F(Desk, ReportsTheStepsAndTheRightOfWhoAsks) {
  const auto report = nlohmann::json::parse(desk_.report(Right::look));
  EXPECT_EQ(report.at("schema"), "ovws.commission/1");
  EXPECT_EQ(report.at("right"), "look");
  EXPECT_EQ(nlohmann::json::parse(desk_.report(Right::control)).at("right"), "control");
  EXPECT_GT(report.at("steps").size(), 10U);
  EXPECT_EQ(desk_.picture("camera"), "");
}

TEST_F(Desk, RefusesWhatIsNoAction) {
  for (const char* body : {"", "[]", R"({"action":1})", R"({"action":"run","else":"x"})",
                           R"({"action":"run","action":"run"})"}) {
    const auto reply = desk_.act(body);
    ASSERT_FALSE(reply) << body;
    EXPECT_EQ(reply.error(), Refusal::malformed);
  }
  EXPECT_EQ(act(R"({"action":"rum"})").at("error").at("data").at("field"), "action");
  EXPECT_EQ(act(R"({"action":"run","step":"camra"})").at("error").at("data").at("field"), "step");
  EXPECT_TRUE(act(R"({"action":"cancel"})").contains("result"));
}

TEST_F(Desk, AnEndedDeskBeginsNothing) {
  desk_.report(Right::look);
  desk_.end();
  EXPECT_EQ(desk_.report(Right::look), "null");
  EXPECT_TRUE(act(R"({"action":"run","step":"camera"})").contains("error"));
}

TEST(CommissionRoutes, EveryoneMayLookAndControlIsNeededToAct) {
  EXPECT_EQ(route_of("/commission")->right, Right::look);
  EXPECT_EQ(route_of("/commission", "POST")->right, Right::control);
  EXPECT_EQ(route_of("/commission", "PUT")->method, "GET");
  EXPECT_EQ(route_of("/commission/picture?step=camera")->right, Right::look);
  EXPECT_FALSE(route_of("/commission/picture"));
}

}  // namespace
}  // namespace ovws::web
