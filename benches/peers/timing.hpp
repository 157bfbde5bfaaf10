// How the programs in C++ measure and print, the same way as `median_seconds` of ../common does for ours.

#pragma once

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <vector>

/// Random states that a function is called on in turn.
constexpr int N_POINTS = 64;
/// A round lasts about this long: far above the resolution of the clock, far below the time between two interruptions.
constexpr double ROUND_SECONDS = 5e-4;
/// The median of so many rounds is the result.
constexpr int N_ROUNDS = 41;

/// Seconds that so many passes over all points take.
template <class Function>
double seconds(Function&& function, int passes) {
  const auto start = std::chrono::steady_clock::now();
  for (int pass = 0; pass < passes; ++pass)
    for (int i = 0; i < N_POINTS; ++i) function(i);
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

/// Time of one call, in microseconds; `function` takes the index of a point.
template <class Function>
double median_microseconds(Function&& function) {
  seconds(function, 1);  // fills the caches
  const int passes = std::max(1, static_cast<int>(std::ceil(ROUND_SECONDS / seconds(function, 1))));
  std::vector<double> times(N_ROUNDS);
  for (double& time : times) time = seconds(function, passes) / (passes * N_POINTS) * 1e6;
  std::nth_element(times.begin(), times.begin() + N_ROUNDS / 2, times.end());
  return times[N_ROUNDS / 2];
}

inline void print(const char* name, double value) { std::printf("%s %.6g\n", name, value); }
