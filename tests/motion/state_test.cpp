// A state keeps accepted postures while further ones are attempted, rejected and accepted.
#include "motion/state.hpp"

#include <gtest/gtest.h>

#include <vector>

namespace assur {
namespace {

constexpr Predictor kTaylor = {Predictor::Kind::taylor, 2}, kHermite = {Predictor::Kind::hermite, 5},
                    kPast = {Predictor::Kind::past, 2};
constexpr double kConstant = 7, kStep = 0.25;  // steps and values are exact in binary

// Coordinate 0 is known and constant; 1 and 2 follow parabolas, which all these predictors continue exactly.
State state(const Predictor& predictor) {
  State s;
  s.resize(1, 3, predictor);
  s.clear();
  s.at(0)[0] = kConstant;
  return s;
}

void put(State& s, double t) {
  for (int i = 1; i < 3; ++i) {
    s.at(0)[i] = i + t - t * t;
    s.at(1)[i] = 1 - 2 * t;
    s.at(2)[i] = -2;
  }
}
void expect_at(const State& s, double t, int derivatives) {
  EXPECT_EQ(s.at(0)[0], kConstant) << t;
  for (int i = 1; i < 3; ++i) {
    EXPECT_EQ(s.at(0)[i], i + t - t * t) << t;
    if (derivatives == 0) continue;
    EXPECT_EQ(s.at(1)[i], 1 - 2 * t) << t;
    EXPECT_EQ(s.at(2)[i], -2) << t;
  }
}

State after_steps(const Predictor& predictor, int steps) {
  State s = state(predictor);
  for (int k = 0; k <= steps; ++k) {
    if (k > 0) s.predict(k * kStep);
    put(s, k * kStep);
    s.accept(k * kStep);
  }
  return s;
}

TEST(State, PredictsFromTheAcceptedPostures) {
  for (const Predictor& predictor : {kTaylor, kHermite, kPast}) {
    State s = after_steps(predictor, 3);
    for (int k = 4; k < 20; ++k) {  // more steps than kept postures
      expect_at(s, (k - 1) * kStep, 2);
      s.predict(k * kStep);
      expect_at(s, k * kStep, 0);
      put(s, k * kStep);
      s.accept(k * kStep);
    }
  }
}

TEST(State, FailedAttemptsLeaveTheAcceptedPosturesAlone) {
  for (const Predictor& predictor : {kTaylor, kHermite, kPast}) {
    State s = after_steps(predictor, 5);
    for (const double h : {2.0, 1.0, 0.5}) {
      s.predict((5 + h) * kStep);
      expect_at(s, (5 + h) * kStep, 0);
      const double t = 5 * kStep, move = h * kStep * (1 - 2 * t - h * kStep);
      EXPECT_EQ(s.predicted_move(1, 2), -move);
      for (int d = 0; d < 3; ++d) s.at(d)[1] = s.at(d)[2] = 1e300;
    }
    s.restore();
    expect_at(s, 5 * kStep, 2);
    s.at(0)[1] = 1e300;  // the prediction does not read this value
    s.predict(6 * kStep);
    expect_at(s, 6 * kStep, 0);
  }
}

TEST(State, PredictsRestAtTheLastPosture) {
  for (const Predictor& predictor : {kTaylor, kHermite, kPast}) {
    State s = after_steps(predictor, 4);
    s.stand_still();
    s.predict(5 * kStep);
    expect_at(s, 4 * kStep, 0);
  }
}

TEST(State, ForgetsOlderPostures) {
  State s = after_steps(kPast, 4);
  s.forget();
  s.predict(5 * kStep);
  expect_at(s, 4 * kStep, 0);  // a prediction from one posture is constant
}

TEST(State, ExpandsWithAllDerivativesOfTheLastPosture) {
  for (const Predictor& predictor : {Predictor{Predictor::Kind::taylor, 1}, kPast}) {
    State s = after_steps(predictor, 4);
    State::Prediction prediction;
    s.begin_expansion(5 * kStep, prediction);
    s.predict(prediction, 0, s.unknowns());
    expect_at(s, 5 * kStep, 0);
  }
}

TEST(State, PredictsThroughKeptPostures) {
  State s = after_steps(kTaylor, 1);
  State::PostureHistory history;
  for (int k = 2; k < 5; ++k) {
    s.save_history(history);
    s.predict(k * kStep);
    put(s, k * kStep);
    s.accept(k * kStep);
  }
  State::Prediction prediction;
  s.begin_prediction(history, 5 * kStep, prediction);
  s.predict(prediction, 0, s.unknowns());  // continues the three postures kept in `history`
  expect_at(s, 5 * kStep, 0);
}

TEST(State, RestartsAfterClear) {
  State s = after_steps(kHermite, 4);
  s.clear();
  for (int d = 0; d < 3; ++d) EXPECT_EQ(s.at(d)[0] + s.at(d)[1] + s.at(d)[2], 0);
  s.at(0)[0] = kConstant;
  put(s, 1);
  s.accept(1);
  s.predict(1 + kStep);
  expect_at(s, 1 + kStep, 0);
}

}  // namespace
}  // namespace assur
