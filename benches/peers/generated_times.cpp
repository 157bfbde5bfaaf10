// Times of compiled C of this crate and of CasADi, one line a function: its name, and microseconds per call.
//
//     generated_times OUR_POINTS THEIR_POINTS VALUES NAME=LIBRARY:FUNCTION:OUTPUTS...
//
// A file of points has N_POINTS rows of q, v and a or tau as double; the lengths of q and v are the first two numbers of the file. OUTPUTS is how
// many numbers a function of this crate has; without it the function is one of CasADi. All values are written to the file VALUES.

#include "timing.hpp"

#include <dlfcn.h>
#include <fstream>
#include <iostream>
#include <string>
#include <vector>

namespace {

struct Points {
  std::size_t nq, nv;
  std::vector<double> rows;

  explicit Points(const char* path) {
    std::ifstream file(path, std::ios::binary);
    double sizes[2];
    file.read(reinterpret_cast<char*>(sizes), sizeof sizes);
    nq = static_cast<std::size_t>(sizes[0]), nv = static_cast<std::size_t>(sizes[1]);
    rows.resize(N_POINTS * width());
    file.read(reinterpret_cast<char*>(rows.data()), static_cast<std::streamsize>(rows.size() * sizeof(double)));
    if (!file) throw std::runtime_error(std::string("cannot read ") + path);
  }

  std::size_t width() const { return nq + 2 * nv; }
  const double* row(int i) const { return rows.data() + i * width(); }
};

template <class Pointer>
Pointer symbol(void* library, const std::string& name) {
  void* found = dlsym(library, name.c_str());
  if (!found) throw std::runtime_error("no function " + name);
  return reinterpret_cast<Pointer>(found);
}

/// Function of this crate: all inputs in one array, all outputs in another.
struct Ours {
  int (*function)(const double*, double*);
  std::vector<double> out;

  Ours(void* library, const std::string& name, std::size_t outputs)
      : function(symbol<int (*)(const double*, double*)>(library, name)), out(outputs) {}

  void call(const Points& points, int i) { function(points.row(i), out.data()); }
  std::vector<double> values() const { return out; }
};

/// Function of CasADi: a pointer to each input and output, and memory to work in.
struct Theirs {
  using Int = long long;
  int (*function)(const double**, double**, Int*, double*, int);
  std::vector<double> out, work;
  std::vector<Int> integers;
  /// Of each output: where its numbers begin, and which entries of a matrix, column by column, they are.
  std::vector<std::size_t> starts;
  std::vector<const Int*> sparsities;
  std::vector<const double*> inputs;
  std::vector<double*> outputs;

  Theirs(void* library, const std::string& name)
      : function(symbol<decltype(function)>(library, name)) {
    const Int n = symbol<Int (*)()>(library, name + "_n_out")();
    const auto sparsity = symbol<const Int* (*)(Int)>(library, name + "_sparsity_out");
    for (Int k = 0; k < n; ++k) {
      starts.push_back(out.size());
      sparsities.push_back(sparsity(k));
      out.resize(out.size() + numbers(sparsity(k)));
    }
    Int sizes[4];
    symbol<int (*)(Int*, Int*, Int*, Int*)>(library, name + "_work")(sizes, sizes + 1, sizes + 2, sizes + 3);
    inputs.resize(sizes[0]), outputs.resize(sizes[1]), integers.resize(sizes[2] + 1), work.resize(sizes[3] + 1);
  }

  /// Rows, columns, then where each column starts and the row of each number, or a one where all numbers are there.
  static std::size_t numbers(const Int* sparsity) {
    return static_cast<std::size_t>(sparsity[2] == 1 ? sparsity[0] * sparsity[1] : sparsity[2 + sparsity[1]]);
  }

  /// With what is always zero.
  std::vector<double> values() const {
    std::vector<double> dense;
    for (std::size_t k = 0; k < starts.size(); ++k) {
      const Int *of = sparsities[k], rows = of[0], columns = of[1];
      const double* next = out.data() + starts[k];
      std::vector<double> matrix(static_cast<std::size_t>(rows * columns));
      for (Int j = 0; j < columns; ++j) {
        const bool full = of[2] == 1;
        for (Int i = full ? 0 : of[2 + j]; i < (full ? rows : of[3 + j]); ++i)
          matrix[static_cast<std::size_t>(j * rows + (full ? i : of[3 + columns + i]))] = *next++;
      }
      dense.insert(dense.end(), matrix.begin(), matrix.end());
    }
    return dense;
  }

  void call(const Points& points, int i) {
    const double* row = points.row(i);
    inputs[0] = row, inputs[1] = row + points.nq, inputs[2] = inputs[1] + points.nv;
    for (std::size_t k = 0; k < starts.size(); ++k) outputs[k] = out.data() + starts[k];
    function(inputs.data(), outputs.data(), integers.data(), work.data(), 0);
  }
};

template <class Function>
void report(const std::string& name, Function function, const Points& points, std::ofstream& values) {
  print(name.c_str(), median_microseconds([&](int i) { function.call(points, i); }));
  for (int i = 0; i < N_POINTS; ++i) {
    function.call(points, i);
    const std::vector<double> all = function.values();
    values.write(reinterpret_cast<const char*>(all.data()), static_cast<std::streamsize>(all.size() * sizeof(double)));
  }
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 5) {
    std::cerr << "usage: see benches/peers/generated.py\n";
    return 2;
  }
  const Points ours(argv[1]), theirs(argv[2]);
  std::ofstream values(argv[3], std::ios::binary);
  for (int k = 4; k < argc; ++k) {
    const std::string word = argv[k];
    const std::size_t equals = word.find('='), first = word.find(':', equals), second = word.find(':', first + 1);
    const std::string name = word.substr(0, equals), path = word.substr(equals + 1, first - equals - 1);
    const std::string function = word.substr(first + 1, second - first - 1);
    void* library = dlopen(path.c_str(), RTLD_NOW | RTLD_LOCAL);
    if (!library) {
      std::cerr << dlerror() << "\n";
      return 1;
    }
    if (second == std::string::npos)
      report(name, Theirs(library, function), theirs, values);
    else
      report(name, Ours(library, function, std::stoul(word.substr(second + 1))), ours, values);
  }
}
