#include "deepslam/core/identifiers.h"

#include <set>
#include <string>

#include <gtest/gtest.h>

namespace deepslam {
namespace {

TEST(IdentifierOf, KeepsPlainNamesAndSpellsOutTheRest) {
  EXPECT_EQ(IdentifierOf("chair_03"), "chair_03");
  EXPECT_EQ(IdentifierOf("Küche 2"), "K_u00FCche_u00202");
  EXPECT_EQ(IdentifierOf("椅子"), "_u6905_u5B50");
  EXPECT_EQ(IdentifierOf("🪑"), "_u1FA91");
  EXPECT_EQ(IdentifierOf("3d"), "_3d");
  EXPECT_EQ(IdentifierOf(""), "_");
  EXPECT_EQ(IdentifierOf("a/b\"<c>"), "a_u002Fb_u0022_u003Cc_u003E");
  EXPECT_EQ(IdentifierOf("\xff\xfe"), "_uFFFD_uFFFD");
}

TEST(Identifiers, AreGivenOutOnce) {
  Identifiers identifiers;
  std::set<std::string> given;
  for (int n = 0; n < 100; ++n) EXPECT_TRUE(given.insert(identifiers.Take("chair")).second);
  EXPECT_TRUE(given.contains("chair") && given.contains("chair_2") && given.contains("chair_100"));
  EXPECT_EQ(identifiers.Take("chair_2"), "chair_2_2");
}

}  // namespace
}  // namespace deepslam
