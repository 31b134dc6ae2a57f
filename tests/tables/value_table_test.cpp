// Ensembles whose members are rows of a table of values: each is the scene with these values, prepared alone.
#include <gtest/gtest.h>

#include <algorithm>
#include <functional>
#include <map>
#include <numbers>
#include <random>

#include "properties/random_count.hpp"
#include "properties/small_random_scenes.hpp"
#include "refusal.hpp"
#include "runs/ensembles.hpp"

namespace assur::test {
namespace {

// Rows of values around `middle`, up to `spread` times its size away; numbers smaller than `least` count as `least`.
struct Table {
  std::vector<std::string> names;
  std::vector<double> values;

  Table(const Parameters& middle, double spread, std::size_t rows, double least = 0) {
    std::mt19937_64 random(5);
    for (const auto& [name, value] : middle) names.push_back(name);
    for (std::size_t i = 0; i < rows; ++i) {
      for (const auto& [name, value] : middle) {
        const double share = static_cast<double>(random() >> 11) * 0x1p-52 - 1;
        values.push_back(value + spread * share * std::max(std::abs(value), least));
      }
    }
  }
  [[nodiscard]] std::size_t rows() const { return values.size() / names.size(); }
  [[nodiscard]] Parameters row(std::size_t i) const {
    Parameters of_row;
    for (std::size_t k = 0; k < names.size(); ++k) of_row[names[k]] = values[i * names.size() + k];
    return of_row;
  }
};

PrepareOptions options(const std::string& strategy) { return {strategy, {}, ThreadBudget{4}}; }

// The number of members that were prepared one by one, by the report.
std::size_t prepared_one_by_one(const Ensemble& e) {
  for (const std::string& text : e.report().fallbacks) {
    if (text.find("were prepared one by one") != std::string::npos) return std::stoul(text);
  }
  return 0;
}
std::string why_one_by_one(const Ensemble& e) {
  for (const std::string& text : e.report().fallbacks) {
    if (text.find("were prepared one by one") != std::string::npos) return text;
  }
  return "";
}

double angle_apart(double a, double b) {
  const double off = std::abs(a - b);
  return std::min(off, std::abs(off - 2 * std::numbers::pi));
}

// Compares a table with an ensemble whose members are prepared. An angle of half a turn may begin on either side.
void expect_like_prepared(const Scene& scene, const Table& table, const std::string& strategy,
                          std::size_t most_prepared = 0) {
  SCOPED_TRACE(scene.name() + " " + strategy);
  Ensemble bound(scene, table.names, table.values, options(strategy));
  const Prepared first = bound.prepared();
  Ensemble each(table.rows(),
                [&](std::size_t i) { return prepare_like(first, scene.with_values(table.row(i)), options(strategy)); });
  const EnsembleTrajectory a = bound.run(), b = each.run();
  EXPECT_LE(prepared_one_by_one(bound), most_prepared) << why_one_by_one(bound);
  std::size_t moved = 0;
  for (std::size_t i = 0; i < table.rows(); ++i) {
    const Ensemble::Outcome &mine = bound.outcomes()[i], &its = each.outcomes()[i];
    EXPECT_EQ(mine.cannot, its.cannot) << i;
    EXPECT_EQ(mine.status.code, its.status.code) << i;
    ASSERT_EQ(a.rows(i), b.rows(i)) << i;
    moved += a.rows(i) > 1 ? 1 : 0;
    std::vector<double> size(a.columns().size(), 1);
    for (std::size_t k = 0; k < a.rows(i); ++k) {
      for (std::size_t c = 0; c < size.size(); ++c) size[c] = std::max(size[c], std::abs(b(i, k, c)));
    }
    for (std::size_t k = 0; k < a.rows(i); ++k) {
      for (std::size_t c = 0; c < size.size(); ++c) {
        ASSERT_LE(angle_apart(a(i, k, c), b(i, k, c)), 1e-9 * size[c]) << i << " " << k << " " << a.columns()[c];
      }
    }
  }
  EXPECT_GT(moved, table.rows() / 2);
}

TEST(ValueTable, BindsParametersOfFiles) {
  const std::map<std::string, Parameters> files = {
      {"four_bar", {{"crank_length", 0.8}, {"coupler_length", 1.8}, {"rocker_length", 1.3}, {"omega", 6}}},
      {"slider_crank", {{"crank_length", 0.1}, {"rod_length", 0.3}}},
      {"stewart", {{"handle", 0.2}, {"rod", 0.55}, {"base_radius", 0.5}, {"toe", 0.2}, {"omega", 1}}},
      {"watt", {{"swing", 0.35}, {"frequency", 0.5}}},
  };
  for (const auto& [name, middle] : files) {
    for (const std::string strategy : {"groups/eigen:4", "groups/lanes:8 2x1"}) {
      expect_like_prepared(read_scene(file(name)).with_time({0, 0.2, 0.01}), Table(middle, 0.02, 21), strategy);
    }
  }
}

// What a function of the program computes in Numbers is repeated; what it computes in double is not, and is noticed.
TEST(ValueTable, BindsParametersOfFunctions) {
  const auto scene = [](const std::function<Number(const Number&)>& length) {
    return parametric_scene({{"crank", 0.8}, {"reach", 2}, {"omega", 6}}, [length](const Parameters& of) {
      const Number crank = of.at("crank"), reach = of.at("reach"), coupler = length(reach);
      return SceneBuilder("f", 2)
          .fixed_point("A", {0, 0})
          .fixed_point("D", {reach, 0})
          .point("B", {crank, 0})
          .point("C", {0.8 * reach, 1.2})
          .constrain("coupler", Distance{"B", "C", coupler})
          .constrain("rocker", Distance{"D", "C", 0.65 * reach})
          .drive("motor", PointAngle{"A", "B", "", Law::polynomial({0, of.at("omega")})})
          .time(0, 0.2, 0.01)
          .build();
    });
  };
  const Table table({{"crank", 0.8}, {"reach", 2}, {"omega", 6}}, 0.02, 21);
  expect_like_prepared(scene([](const Number& reach) { return sqrt(reach * reach - 0.76); }), table, "groups/lanes:8");
  const auto in_double = [](const Number& reach) { return Number(std::sqrt(reach * reach - 0.76)); };
  expect_like_prepared(scene(in_double), table, "groups/lanes:8", 21);
  Ensemble one_by_one(scene(in_double), table.names, table.values, options("groups/lanes:8"));
  (void)one_by_one.run();
  EXPECT_NE(why_one_by_one(one_by_one).find("cannot be repeated without the scene"), std::string::npos);
}

// All lengths of 12,000 rods depend on the values.
TEST(ValueTable, BindsLargeMechanisms) {
  Ensemble legs(sample("jansen:legs=2000").with_outputs({"footR1"}).with_time({0, 0.01, 0.01}), {"La", "Lb"},
                {0.38, 0.415, 0.381, 0.414}, options("groups/lanes:8"));
  const EnsembleTrajectory motion = legs.run();
  EXPECT_EQ(prepared_one_by_one(legs), 0u) << why_one_by_one(legs);
  for (const Ensemble::Outcome& member : legs.outcomes()) EXPECT_TRUE(member.status.ok());
}

TEST(ValueTable, BindsOptionsOfSamples) {
  expect_like_prepared(sample("slider_crank").with_time({0, 0.5, 0.01}),
                       Table({{"crank_length", 0.1}, {"rod_length", 0.3}, {"offset", 0.02}}, 0.1, 20),
                       "groups/eigen:4");
  expect_like_prepared(sample("jansen").with_time({0, 0.2, 0.01}),
                       Table({{"La", 0.38}, {"Lb", 0.415}, {"Lc", 0.393}, {"Lm", 0.15}}, 0.01, 20), "groups/lanes:8");
  expect_like_prepared(sample("scissor").with_time({0, 0.5, 0.02}), Table({{"arm", 2}, {"time", 10}}, 0.02, 20),
                       "groups/eigen:4");
}

// Numbers of the file, without a parameter: positions, lengths, members, places of joints.
TEST(ValueTable, BindsNumbers) {
  expect_like_prepared(read_scene(file("four_bar")).with_time({0, 0.3, 0.01}),
                       Table({{"A1.x", 2}, {"A1.y", 0}, {"coupler1", 1.8}}, 0.02, 20, 0.1), "groups/eigen:4");
  expect_like_prepared(read_scene(file("delta")).with_time({0, 0.2, 0.01}),
                       Table({{"S1.x", 0.2}, {"S1.z", 0}, {"S2.x", -0.1}}, 0.01, 20, 0.1), "groups/lanes:16");
  expect_like_prepared(read_scene(file("watt")).with_time({0, 0.2, 0.01}),
                       Table({{"A.x", -1}, {"A.y", 0.25}, {"D.y", -0.25}, {"M.x", 0}}, 0.02, 20, 0.1),
                       "groups/eigen:4");
}

// Up to six numbers of a scene: coordinates of fixed points and of places of joints, and lengths.
Parameters some_numbers(const Scene& scene) {
  Parameters middle;
  const auto add = [&](const std::string& name, double value) {
    if (middle.size() < 6) middle.emplace(name, value);
  };
  const auto add_place = [&](const std::string& name, const Triple& at) {
    for (std::size_t k = 0; k < static_cast<std::size_t>(scene.dimension()); ++k) add(name + "." + "xyz"[k], at[k]);
  };
  for (const Joint& joint : scene.joints()) {
    std::visit(
        [&](const auto& kind) {
          if constexpr (requires { kind.at; }) {
            if (const auto* at = std::get_if<Triple>(&kind.at)) add_place(joint.name, *at);
          }
        },
        joint.kind);
  }
  for (const Point& p : scene.points()) {
    if (p.fixed && scene.joints().empty()) add_place(p.name, p.at);
  }
  return middle;
}

// If this fails with another number of members that are prepared one by one, look for numbers of the scene that are
// computed in double where they should be Numbers.
TEST(ValueTable, BindsNumbersOfShippedScenes) {
  for (const std::string name : {"andrews", "delta", "double_wishbone", "excavator", "hexa", "jansen", "klann",
                                 "peaucellier", "slider_crank", "stewart", "three_rps"}) {
    const Scene scene = read_scene(file(name));
    const TimeGrid time = scene.time();
    expect_like_prepared(scene.with_time({time.start, time.start + 5 * time.step, time.step}),
                         Table(some_numbers(scene), 1e-3, 9, 0.1), "irreducible/eigen:4");
  }
}

// Fixed points of random mechanisms move a little; what is written as the distance of points follows.
TEST(ValueTable, BindsRandomMechanisms) {
  std::size_t bound = 0, all = 0;
  for (std::uint64_t seed = 1; seed <= static_cast<std::uint64_t>(test::random_count(30)); ++seed) {
    Draw draw(seed);
    const Scene scene = seed % 2 == 0 ? planar_mechanism(draw) : spatial_mechanism(draw);
    Parameters middle;
    for (const Point& p : scene.points()) {
      for (std::size_t k = 0; p.fixed && k < static_cast<std::size_t>(scene.dimension()); ++k) {
        middle[p.name + "." + "xyz"[k]] = p.at[k];
      }
    }
    const Table table(middle, 1e-3, 9, 0.1);
    expect_like_prepared(scene, table, "groups/eigen:4", table.rows());
    Ensemble e(scene, table.names, table.values, options("groups/eigen:4"));
    (void)e.run();
    bound += table.rows() - prepared_one_by_one(e);
    all += table.rows();
    if (HasFailure()) return;
  }
  EXPECT_GT(bound, all * 9 / 10);
}

// Values that prepare() refuses, or that lead to another computation.
// Each member starts at the end of the way from its own drawing: where a motion over this way ends.
TEST(ValueTable, MembersStartAtTheEndsOfTheirWays) {
  const auto lever = [](const std::string& law, const std::string& time) {
    return parse_scene(R"({"assur": 1, "name": "lever", "dimension": 2, "parameters": {"start": 0.1, "place": 0.4},
      "bodies": {"lever": {}, "block": {}, "crank": {}},
      "joints": {"O": {"revolute": ["ground", "lever"], "at": [0, 0]},
                 "S": {"prismatic": ["lever", "block"], "axis": [0.5, 0.8660254037844386]},
                 "Q": {"revolute": ["block", "crank"], "at": [0.5, 0.8660254037844386]},
                 "P": {"revolute": ["ground", "crank"], "at": ["=place", 0.1]}},
      "drivers": {"turn": {"coordinate": "O.angle", "law": {"polynomial": )" +
                       law + R"(}}}, "outputs": ["Q"], "time": )" + time + "}");
  };
  const Scene scene = lever(R"(["=start", 0.1])", R"({"start": 0, "end": 0.02, "step": 0.01})");
  const Scene motion = lever(R"([0, "=start"])", R"({"start": 0, "end": 1, "step": 0.01})");
  const std::vector<double> starts = {-1.3, -1.2, -0.9, -0.5, -1e-3, 0, 0.3, 0.7, 1.1};
  Table table({{"place", 0.4}, {"start", 0}}, 0.05, starts.size());
  for (std::size_t i = 0; i < starts.size(); ++i) table.values[2 * i + 1] = starts[i];
  for (const std::string strategy : {"groups/eigen:4", "irreducible/lanes:8"}) {
    Ensemble members(scene, table.names, table.values, options(strategy));
    const EnsembleTrajectory all = members.run();
    EXPECT_EQ(prepared_one_by_one(members), 0u) << why_one_by_one(members);
    for (std::size_t i = 0; i < starts.size(); ++i) {
      Simulator simulator(prepare(motion.with_values(table.row(i)), options(strategy)));
      const Trajectory way = simulator.run();
      ASSERT_TRUE(simulator.report().status.arrived());
      ASSERT_GT(all.rows(i), 0u);
      for (const char* column : {"Q.x", "Q.y"}) {
        const auto at = static_cast<std::size_t>(std::find(all.columns().begin(), all.columns().end(), column) -
                                                 all.columns().begin());
        EXPECT_NEAR(all(i, 0, at), way.last(column), 1e-12) << i << ' ' << column;
      }
    }
  }
}

TEST(ValueTable, MembersThatCannotBePrepared) {
  const Scene scene = read_scene(file("four_bar")).with_time({0, 0.3, 0.01});
  std::vector<double> values;
  for (std::size_t i = 0; i < 40; ++i) values.insert(values.end(), {0.5 + 0.01 * static_cast<double>(i), 1.8, 1.3});
  values[3 * 3 + 1] = -1.8;                                      // no length
  values[7 * 3 + 2] = std::numeric_limits<double>::quiet_NaN();  // no number
  values[11 * 3 + 1] = 0.01;                                     // too short
  values[12 * 3] = 0;                                            // no crank
  values[20 * 3] = std::numeric_limits<double>::infinity();
  Ensemble e(scene, {"crank_length", "coupler_length", "rocker_length"}, values, options("groups/eigen:8 2x1"));
  const EnsembleTrajectory all = e.run();
  for (std::size_t i = 0; i < 40; ++i) {
    const Parameters set = {
        {"crank_length", values[3 * i]}, {"coupler_length", values[3 * i + 1]}, {"rocker_length", values[3 * i + 2]}};
    std::string why;
    try {
      (void)prepare(scene.with_values(set), options("groups/eigen"));
      expect_member(e, all, i, scene.with_values(set), "groups/eigen");
    } catch (const Error& error) {
      why = error.what();
    }
    EXPECT_EQ(e.outcomes()[i].cannot, why) << i;
    EXPECT_EQ(all.rows(i) == 0, !why.empty()) << i;
  }
  EXPECT_FALSE(e.outcomes()[3].cannot.empty() || e.outcomes()[11].cannot.empty());
  EXPECT_LE(prepared_one_by_one(e), 6u) << why_one_by_one(e);
}

// The sample chooses the side of its start posture by the pivot.
TEST(ValueTable, AnotherComputation) {
  const Scene scene = sample("whitworth").with_time({0, 0.3, 0.01});
  Table table({{"pivot", 0.1}}, 0.8, 24);
  expect_like_prepared(scene, table, "groups/eigen:4", table.rows());
}

TEST(ValueTable, ScenesThatArePreparedOneByOne) {
  const auto why = [](const Scene& scene, const Parameters& middle, double spread) {
    const Table table(middle, spread, 4, 1);
    expect_like_prepared(scene, table, "groups/eigen:4", 4);
    Ensemble e(scene, table.names, table.values, options("groups/eigen:4"));
    (void)e.run();
    return why_one_by_one(e);
  };
  EXPECT_EQ(why(sample("parallelograms").with_time({0, 0.1, 0.01}), {{"omega", 1}}, 0.1),
            "4 of 4 members were prepared one by one, because the scene has redundant equations");
  const Scene turned = with_law(turning(3)).with_time({0, 0.1, 0.01});
  EXPECT_EQ(why(turned, {{"coupler", 1.8}}, 0.01),
            "4 of 4 members were prepared one by one, because the scene has functions of the program");
  // What is used as a plain double.
  const auto with = [](const std::string& law, const std::string& start) {
    return parse_scene(R"({"assur": 1, "dimension": 2, "parameters": {"p": 0.5}, "points": {
        "A": {"at": [0, 0], "fixed": true}, "D": {"at": [2, 0], "fixed": true}, "B": {"at": [0.8, 0]},
        "C": {"at": [1.6, 1.2]}},
      "constraints": {"coupler": {"distance": ["B", "C"]}, "rocker": {"distance": ["D", "C"]}},
      "drivers": {"motor": {"angle": ["A", "B"], "law": )" +
                       law + R"(}}, "time": {"start": )" + start + R"(, "end": 1, "step": 0.125}})");
  };
  const std::string lost = "numbers of the scene depend on the values in a way that cannot be repeated";
  EXPECT_NE(why(with(R"({"table": [[0, 0], [1, "=p"]]})", "0"), {{"p", 0.5}}, 0.1).find(lost), std::string::npos);
  Ensemble late(with(R"({"polynomial": [0, 1]})", R"("=p")"), {"p"}, {0.5, 0.25}, options("groups/eigen:4"));
  (void)late.run();
  EXPECT_NE(why_one_by_one(late).find(lost), std::string::npos);
}

TEST(ValueTable, Gears) {
  const Scene scene = read_scene(file("geared_five_bar")).with_time({0, 0.2, 0.01});
  const Table places({{"C.x", 0.8}, {"E.x", 1.2}}, 0.02, 24);
  expect_like_prepared(scene, places, "irreducible/lanes:8", 4);
  expect_like_prepared(scene, places, "groups/eigen:4", 4);
  Table ratios({{"gears", -2}}, 0.02, 4);
  ratios.values = {-2, -1.5, -2, -2.5};
  expect_like_prepared(scene, ratios, "irreducible/lanes:8", 4);
  Ensemble e(scene, ratios.names, ratios.values, options("irreducible/lanes:8"));
  (void)e.run();
  EXPECT_EQ(prepared_one_by_one(e), 4u);
}

// Some of the members reach a fold.
TEST(ValueTable, MembersThatEndEarly) {
  const Scene scene = limited_four_bar(Law::polynomial({0.5, 0.75})).time(0, 1.5, 0.01).build();
  std::string coupler;
  for (const Constraint& c : scene.constraints()) {
    if (const auto* d = c.as<Distance>(); d != nullptr && d->value) coupler = c.name;
  }
  ASSERT_NE(coupler, "");
  const double length = *std::find_if(scene.constraints().begin(), scene.constraints().end(),
                                      [&](const Constraint& c) { return c.name == coupler; })
                             ->as<Distance>()
                             ->value;
  const Table table({{coupler, length}}, 0.02, 16);
  Ensemble e(scene, table.names, table.values, options("groups/eigen:4"));
  const EnsembleTrajectory all = e.run();
  EXPECT_EQ(prepared_one_by_one(e), 0u);
  std::size_t ended = 0;
  for (std::size_t i = 0; i < table.rows(); ++i) {
    expect_member(e, all, i, scene.with_values(table.row(i)), "groups/eigen");
    ended += e.outcomes()[i].status.ok() ? 0 : 1;
  }
  EXPECT_GT(ended, 0u);
}

TEST(ValueTable, ThreadsChangeNoBit) {
  const Scene scene = read_scene(file("stewart")).with_time({0, 0.1, 0.01});
  const Table table({{"handle", 0.2}, {"rod", 0.55}, {"toe", 0.2}}, 0.05, 70);
  std::optional<EnsembleTrajectory> one;
  for (const std::string strategy : {"groups/lanes:8", "groups/lanes:8 2x1", "groups/lanes:8 4x1"}) {
    Ensemble e(scene, table.names, table.values, options(strategy));
    const EnsembleTrajectory first = e.run(), again = e.run();
    expect_same_bits(first, again);
    if (one) expect_same_bits(*one, first);
    one = first;
    const EnsembleSummary summary = e.summarize({first.columns()[0]});
    for (std::size_t i = 0; i < table.rows(); ++i) {
      EXPECT_EQ(summary(i, 0).last, first(i, first.rows(i) - 1, 0));
    }
  }
}

TEST(ValueTable, TakesAnotherTable) {
  const Scene scene = read_scene(file("four_bar")).with_time({0, 0.3, 0.01});
  const std::vector<std::string> names = {"crank_length", "rocker_length"};
  Ensemble e(scene, names, {0.8, 1.3, 0.7, 1.3}, options("groups/eigen:4"));
  (void)e.run();
  for (const std::vector<double>& values :
       {std::vector{0.6, 1.3, 0.5, 1.3, 0.4, 1.3}, std::vector{0.6, 1.2, 0.5, 1.25}, std::vector{0.75, 1.4}}) {
    e.bind(values);
    EXPECT_EQ(e.members(), values.size() / 2);
    EXPECT_TRUE(e.outcomes().empty());
    const EnsembleTrajectory all = e.run();
    EXPECT_EQ(prepared_one_by_one(e), 0u) << why_one_by_one(e);
    ASSERT_EQ(all.members(), values.size() / 2);
    for (std::size_t i = 0; i < all.members(); ++i) {
      expect_member(e, all, i,
                    scene.with_values({{"crank_length", values[2 * i]}, {"rocker_length", values[2 * i + 1]}}),
                    "groups/eigen");
    }
  }
}

TEST(ValueTable, Refusals) {
  const Scene scene = read_scene(file("four_bar"));
  const auto made = [&](std::vector<std::string> names, std::vector<double> values) {
    return refusal([&] { (void)Ensemble(scene, std::move(names), std::move(values), options("groups/eigen")); });
  };
  EXPECT_EQ(made({"crank_lenght"}, {1}),
            "the scene has no parameter and no number 'crank_lenght'; did you mean 'crank_length'?");
  EXPECT_EQ(made({"A1.x", "A1.x"}, {1, 2}), "'A1.x' names two columns of the table");
  EXPECT_EQ(made({}, {}), "a table of values needs at least one name");
  const std::string rows = "a table with 2 names needs as many values for each member, and at least one member; ";
  EXPECT_EQ(made({"A1.x", "A1.y"}, {1, 2, 3}), rows + "3 values are no whole rows");
  EXPECT_EQ(made({"A1.x", "A1.y"}, {}), rows + "0 values are no whole rows");
  Ensemble impossible(scene, {"crank_length"}, {-1, -2}, options("groups/eigen"));
  (void)impossible.run();
  EXPECT_NE(impossible.outcomes().at(0).cannot.find("a distance must be > 0"), std::string::npos);
  Ensemble e(scene, {"A1.x"}, {2, 2.1}, options("groups/eigen"));
  EXPECT_NE(refusal([&] { e.bind({}); }), "");
  EXPECT_EQ(e.run(std::vector{0.0}).members(), 2u);
  Ensemble each = ensemble(2, four_bar);
  EXPECT_EQ(refusal([&] { each.bind({1}); }),
            "the members of this ensemble were prepared one by one; an ensemble with a table of values takes another "
            "table");
}

TEST(ValueTable, ObserverStopsIt) {
  const Scene scene = read_scene(file("four_bar")).with_time({0, 0.3, 0.01});
  const Table table({{"crank_length", 0.8}}, 0.1, 30);
  Ensemble e(scene, table.names, table.values, options("groups/eigen:4"));
  std::int64_t last = 0, of = 0;
  (void)e.run([&](std::int64_t done, std::int64_t all) {
    EXPECT_GE(done, last);
    last = done, of = all;
    return false;
  });
  EXPECT_EQ(last, 30 * 31);
  EXPECT_EQ(of, 30 * 31);
  // Half of the members are prepared one by one, because nobody has a crank of length 0 or less.
  std::vector<double> values = table.values;
  for (std::size_t i = 0; i < values.size(); i += 2) values[i] = -values[i];
  Ensemble half(scene, table.names, values, options("groups/eigen:4"));
  last = 0;
  (void)half.run([&](std::int64_t done, std::int64_t) {
    EXPECT_GE(done, last);
    last = done;
    return false;
  });
  EXPECT_EQ(last, 15 * 31);
  (void)e.run([&](std::int64_t done, std::int64_t) { return done >= 100; });
  const auto interrupted = std::count_if(e.outcomes().begin(), e.outcomes().end(),
                                         [](const auto& o) { return o.status.code == Code::interrupted; });
  EXPECT_GT(interrupted, 20);
}

}  // namespace
}  // namespace assur::test
