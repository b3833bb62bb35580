#include <cmath>
#include <gtest/gtest.h>
#include <limits>
#include <sstream>

#include "scene/expression/trigger.h"
#include "scene_test.h"

using namespace insitu::scene;

namespace {

double reduce(Reduction reduction, const std::string& field) {
  if (field == "nan") {
    return std::numeric_limits<double>::quiet_NaN();
  }
  const double base = field == "pressure" ? 10 : 100;
  return reduction == Reduction::min ? base : reduction == Reduction::max ? base + 2 : base + 1;
}

bool holds(const std::string& text, std::int64_t cycle = 7, double time = 0.5) {
  return Expression(text).evaluate(cycle, time, reduce);
}

/// "column: message" of the error.
std::string error(const std::string& text) {
  try {
    Expression{text};
  } catch (const ExpressionError& e) {
    return std::to_string(e.column) + ": " + e.what();
  }
  return "no error";
}

} // namespace

TEST(Trigger, Comparisons) {
  const struct {
    const char* symbol;
    bool below, same, above;
  } table[] = {{"<", true, false, false}, {"<=", true, true, false},  {">", false, false, true},
               {">=", false, true, true}, {"==", false, true, false}, {"!=", true, false, true}};
  for (const auto& row : table) {
    EXPECT_EQ(holds(std::string("1 ") + row.symbol + " 2"), row.below) << row.symbol;
    EXPECT_EQ(holds(std::string("2") + row.symbol + "2"), row.same) << row.symbol;
    EXPECT_EQ(holds(std::string("3 ") + row.symbol + " 2"), row.above) << row.symbol;
  }
}

TEST(Trigger, Values) {
  EXPECT_TRUE(holds("cycle == 7"));
  EXPECT_TRUE(holds("time == .5"));
  EXPECT_TRUE(holds("min(pressure) == 10"));
  EXPECT_TRUE(holds("max(pressure) == 12"));
  EXPECT_TRUE(holds("mean ( pressure ) == 11"));
  EXPECT_TRUE(holds("max('wind speed') == 102"));
  EXPECT_TRUE(holds("max(\"wind speed\") == 102"));
  EXPECT_TRUE(holds("abs(-3) == 3 and abs(3) == 3"));
  EXPECT_TRUE(holds("1e3 == 1000 and 2.5e-1 == 0.25 and 1. == 1"));
}

TEST(Trigger, ArithmeticBindsAsUsual) {
  EXPECT_TRUE(holds("1 + 2 * 3 == 7"));
  EXPECT_TRUE(holds("(1 + 2) * 3 == 9"));
  EXPECT_TRUE(holds("10 - 4 - 3 == 3"));
  EXPECT_TRUE(holds("16 / 4 / 2 == 2"));
  EXPECT_TRUE(holds("-2 * -3 == 6"));
  EXPECT_TRUE(holds("--2 == +2"));
  EXPECT_TRUE(holds("1 - -1 == 2"));
}

TEST(Trigger, LogicBindsAsUsual) {
  // For each operands: `or` last, `not` first, and both spellings the same.
  for (const bool a : {false, true}) {
    for (const bool b : {false, true}) {
      for (const bool c : {false, true}) {
        const auto term = [](bool value) { return value ? "1 < 2" : "2 < 1"; };
        const auto both = [&](const char* left, const char* middle, const char* right) {
          std::ostringstream text;
          text << left << term(a) << middle << term(b) << right << term(c);
          return holds(text.str());
        };
        EXPECT_EQ(both("", " or ", " and "), a || (b && c));
        EXPECT_EQ(both("", " || ", " && "), a || (b && c));
        EXPECT_EQ(both("", " and ", " or "), (a && b) || c);
        EXPECT_EQ(both("(", " or ", ") and "), (a || b) && c);
        EXPECT_EQ(both("not ", " and ", " or "), (!a && b) || c);
        EXPECT_EQ(both("!(", " && ", ") and "), !(a && b) && c);
      }
    }
  }
}

TEST(Trigger, NaNComparesFalse) {
  for (const char* symbol : {"<", "<=", ">", ">=", "=="}) {
    EXPECT_FALSE(holds(std::string("max(nan) ") + symbol + " 1")) << symbol;
  }
  EXPECT_TRUE(holds("max(nan) != 1"));
}

TEST(Trigger, ReducesOnceAndOnlyWhatDecides) {
  int calls = 0;
  const auto counting = [&](Reduction reduction, const std::string& field) {
    ++calls;
    return reduce(reduction, field);
  };
  EXPECT_TRUE(Expression("max(pressure) > 1 and max(pressure) < 20").evaluate(0, 0, counting));
  EXPECT_EQ(calls, 1);
  calls = 0;
  EXPECT_FALSE(Expression("cycle > 5 and max(pressure) > 1").evaluate(0, 0, counting));
  EXPECT_TRUE(Expression("cycle < 5 or max(pressure) > 1").evaluate(0, 0, counting));
  EXPECT_EQ(calls, 0);
}

TEST(Trigger, ListsWhatItUses) {
  const Expression expression("max(a) > min(b) or max(a) > mean('c d') + min(a)");
  const std::vector<Expression::FieldUse> expected = {{Reduction::max, "a"},
                                                      {Reduction::min, "b"},
                                                      {Reduction::mean, "c d"},
                                                      {Reduction::min, "a"}};
  EXPECT_EQ(expression.uses(), expected);
  EXPECT_TRUE(Expression("cycle > 1").uses().empty());
}

TEST(Trigger, ErrorsHaveColumns) {
  EXPECT_EQ(error(""), "1: the condition is empty");
  EXPECT_EQ(error("  "), "3: the condition is empty");
  EXPECT_EQ(error("max(pressure)"),
            "1: a condition expected, a number found; compare it with something");
  EXPECT_EQ(error("1 < 2 and 3"),
            "11: a condition expected, a number found; compare it with something");
  EXPECT_EQ(error("not 3"), "5: a condition expected, a number found; compare it with something");
  EXPECT_EQ(error("1 + (2 < 3) < 4"), "5: a number expected, a condition found");
  EXPECT_EQ(error("abs(1 < 2) > 0"), "5: a number expected, a condition found");
  EXPECT_EQ(error("1 < 2 < 3"), "7: comparisons cannot be chained; join two of them by 'and'");
  EXPECT_EQ(error("cycle = 3"), "7: '=' is not a comparison; write '=='");
  EXPECT_EQ(error("cycle >"), "8: a value expected, end of the condition found");
  EXPECT_EQ(error("cycle > 1)"), "10: unexpected ')'");
  EXPECT_EQ(error("(cycle > 1"),
            "11: ')' expected at the end of the parenthesis, end of the condition found");
  EXPECT_EQ(error("cycle > 1 cycle"), "11: unexpected 'cycle'");
  EXPECT_EQ(error("cycle > 3x"), "9: '3x' is not a number");
  EXPECT_EQ(error("cycle > 1e999"), "9: '1e999' is not a finite number");
  EXPECT_EQ(error("max() > 1"), "5: the name of a field expected in max(...), ')' found");
  EXPECT_EQ(error("max > 1"), "5: '(' expected after 'max', '>' found");
  EXPECT_EQ(error("max('p) > 1"), "5: the quotation mark is not closed");
  EXPECT_EQ(error("cycle > \xE2\x82\xAC"), "9: a value expected, '\xE2\x82\xAC' found");
}

TEST(Trigger, ErrorsNameTheNearestWord) {
  EXPECT_EQ(
      error("maxx(p) > 1"),
      "1: the function 'maxx' is unknown; did you mean 'max'? (functions: min, max, mean, abs)");
  EXPECT_EQ(error("cylce > 1"),
            "1: the name 'cylce' is unknown; did you mean 'cycle'?; a field is used as min(field), "
            "max(field) or mean(field)");
  EXPECT_NE(error("max(a + b) > 1").find("max takes one field"), std::string::npos);
}

TEST(Trigger, DepthAndLengthAreLimited) {
  EXPECT_NE(error(std::string(5000, ' ')).find("5000 bytes"), std::string::npos);
  EXPECT_NE(error(std::string(2000, '(') + "1 < 2").find("64 levels"), std::string::npos);
  EXPECT_NE(error(std::string(2000, '!') + "(1 < 2)").find("64 levels"), std::string::npos);
  EXPECT_NE(error(std::string(2000, '-') + "1 < 2").find("64 levels"), std::string::npos);
  std::string chain = "1";
  for (int i = 0; i < 1000; ++i) {
    chain += "+1";
  }
  EXPECT_TRUE(holds(chain + " == 1001"));
  for (int i = 0; i < 200; ++i) {
    chain += "+1";
  }
  EXPECT_NE(error(chain + " > 0").find("terms in a row"), std::string::npos);
}

TEST(Trigger, ParseShowsTheColumnWithACaret) {
  EXPECT_EQ(test::error_of_call([] { Expression::parse("max(p) >> 2", "s.yaml", 12); }),
            "s.yaml:12: a value expected, '>' found (column 9 of the condition)\n"
            "    max(p) >> 2\n"
            "            ^");
  // Of a long condition only the surroundings are shown.
  const std::string text = std::string(500, ' ') + "cycle > ?" + std::string(500, ' ');
  const std::string message = test::error_of_call([&] { Expression::parse(text, "s.yaml", 1); });
  EXPECT_LT(message.size(), 400u);
  EXPECT_NE(message.find("column 509"), std::string::npos);
  const std::size_t shown = message.find('\n') + 1, caret = message.rfind('\n') + 1;
  EXPECT_EQ(message.find('?', shown) - shown, message.find('^', caret) - caret);
}

TEST(Trigger, AtAPointFieldsStandAlone) {
  const auto at = [](const char* text, const std::vector<double>& values, double age) {
    return Expression(text, Expression::Scope::point).evaluate_at(3, 0.5, age, values);
  };
  EXPECT_TRUE(at("salt < 5 and (temp - 2 * salt > 1 or age >= 10)", {4.0, 9.5}, 0.0));
  EXPECT_FALSE(at("salt < 5 and (temp - 2 * salt > 1 or age >= 10)", {4.0, 8.5}, 9.0));
  EXPECT_TRUE(at("salt < 5 and (temp - 2 * salt > 1 or age >= 10)", {4.0, 8.5}, 10.0));
  EXPECT_TRUE(at("'age' > 1 and cycle == 3 and time == 0.5", {2.0}, 0.0));
  EXPECT_TRUE(at("abs(\"wind speed\") == 2 and \"wind speed\" < 0", {-2.0}, 0.0));
  EXPECT_FALSE(at("salt < 5 or salt >= 5", {std::nan("")}, 0.0));
  const auto wrong = [](const char* text) {
    try {
      Expression(text, Expression::Scope::point);
    } catch (const ExpressionError& e) {
      return std::string(e.what());
    }
    return std::string();
  };
  EXPECT_NE(wrong("max(salt) > 1").find("a field is its value there"), std::string::npos);
  EXPECT_NE(wrong("max > 1").find("a field of this name is quoted"), std::string::npos);
  EXPECT_NE(wrong("salt").find("a condition expected"), std::string::npos);
  EXPECT_NE(wrong("salt > ").find("a value expected"), std::string::npos);
  EXPECT_THROW(Expression("salt > 1"), ExpressionError); // a mesh has many
}

TEST(Trigger, Due) {
  Trigger trigger;
  trigger.every = 10;
  EXPECT_TRUE(trigger.due(0, 0, reduce));
  EXPECT_FALSE(trigger.due(15, 0, reduce));
  EXPECT_TRUE(trigger.due(20, 0, reduce));
  trigger.when = Expression("time > 1");
  EXPECT_FALSE(trigger.due(20, 1, reduce));
  EXPECT_TRUE(trigger.due(20, 1.5, reduce));
  EXPECT_FALSE(trigger.due(21, 1.5, reduce));
}
