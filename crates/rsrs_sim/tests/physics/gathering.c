/* Aggregation without computation, by a simulator of its own.
 *
 * Written from M. Gauci, J. Chen, W. Li, T. J. Dodd and R. Gross, "Self-organized aggregation without
 * computation", IJRR 33(8), 2014, and from nothing of the program that it is held against: exact arcs in
 * double precision, a line of sight that meets a disc or does not, bodies moved apart pair by pair, one
 * after the other, in four parts of a step. No random number is shared.
 *
 * gathering ROBOTS RUNS SEED RANGE_M TIME_S...
 *
 * prints, for each of the ascending times, in how many of the runs nine tenths of the robots or more were in
 * one cluster: no two neighbours in it further than four radii apart.
 */

#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>

#define WHEEL_M_S 0.128
#define AXLE_M 0.051
#define RADIUS_M 0.037
#define PERIOD_S 0.1
#define PARTS 4
#define ROUNDS 500
#define MOST 128

static uint64_t state;

static double uniform(void) { /* xorshift64* */
  state ^= state >> 12;
  state ^= state << 25;
  state ^= state >> 27;
  return (double)((state * 2685821657736338717ULL) >> 11) / 9007199254740992.0;
}

static int n;
static double x[MOST], y[MOST], heading[MOST];

/* One square metre for each robot, anywhere in it, heading anywhere. */
static void start(void) {
  double side = sqrt(n);
  for (int i = 0; i < n;) {
    x[i] = side * (uniform() - 0.5);
    y[i] = side * (uniform() - 0.5);
    heading[i] = 2 * M_PI * uniform();
    int fits = 1;
    for (int j = 0; j < i; j++) fits &= hypot(x[i] - x[j], y[i] - y[j]) >= 2.2 * RADIUS_M;
    i += fits;
  }
}

/* Whether the line ahead of a robot, from its centre on, meets the body of another one. */
static int sees(int i, double range) {
  for (int j = 0; j < n; j++) {
    if (j == i) continue;
    double ahead = (x[j] - x[i]) * cos(heading[i]) + (y[j] - y[i]) * sin(heading[i]);
    double aside = (y[j] - y[i]) * cos(heading[i]) - (x[j] - x[i]) * sin(heading[i]);
    double on_line = ahead < 0 ? 0 : ahead > range ? range : ahead;
    if (hypot(ahead - on_line, aside) <= RADIUS_M) return 1;
  }
  return 0;
}

static void move(int i, double left, double right, double time) {
  double speed = WHEEL_M_S * (left + right) / 2, turn = WHEEL_M_S * (right - left) / AXLE_M;
  double to = heading[i] + turn * time;
  x[i] += speed / turn * (sin(to) - sin(heading[i]));
  y[i] += speed / turn * (cos(heading[i]) - cos(to));
  heading[i] = to;
}

static void push_apart(void) {
  for (int round = 0, any = 1; any && round < ROUNDS; round++) {
    any = 0;
    for (int i = 0; i < n; i++)
      for (int j = 0; j < i; j++) {
        double dx = x[i] - x[j], dy = y[i] - y[j], d2 = dx * dx + dy * dy;
        if (d2 >= 4 * RADIUS_M * RADIUS_M * (1 - 1e-4) || d2 == 0) continue;
        double d = sqrt(d2), half = (2 * RADIUS_M - d) / 2;
        x[i] += half * dx / d, y[i] += half * dy / d;
        x[j] -= half * dx / d, y[j] -= half * dy / d;
        any = 1;
      }
  }
}

static void step(double range) {
  int seen[MOST];
  for (int i = 0; i < n; i++) seen[i] = sees(i, range);
  for (int part = 0; part < PARTS; part++) {
    for (int i = 0; i < n; i++) {
      if (seen[i]) move(i, 1, -1, PERIOD_S / PARTS);
      else move(i, -0.7, -1, PERIOD_S / PARTS);
    }
    push_apart();
  }
}

/* The robots of the largest cluster, found by spreading from one to the next. */
static int largest_cluster(void) {
  int known[MOST] = {0}, largest = 0;
  for (int first = 0; first < n; first++) {
    if (known[first]) continue;
    int stack[MOST], height = 0, size = 0;
    stack[height++] = first, known[first] = 1;
    while (height) {
      int i = stack[--height];
      size++;
      for (int j = 0; j < n; j++)
        if (!known[j] && hypot(x[i] - x[j], y[i] - y[j]) < 4 * RADIUS_M)
          stack[height++] = j, known[j] = 1;
    }
    if (size > largest) largest = size;
  }
  return largest;
}

int main(int argc, char **argv) {
  if (argc < 6 || (n = atoi(argv[1])) < 1 || n > MOST) return 2;
  int runs = atoi(argv[2]), n_times = argc - 5;
  double range = atof(argv[4]);
  int *gathered = calloc(n_times, sizeof *gathered);
  for (int run = 0; run < runs; run++) {
    state = 0x9E3779B97F4A7C15ULL * (atoi(argv[3]) * 1000003ULL + run + 1);
    for (int i = 0; i < 20; i++) uniform();
    start();
    long now = 0;
    for (int time = 0; time < n_times; time++) {
      for (long until = lround(atof(argv[5 + time]) / PERIOD_S); now < until; now++) step(range);
      gathered[time] += 10 * largest_cluster() >= 9 * n;
    }
  }
  for (int time = 0; time < n_times; time++) printf("%d ", gathered[time]);
  printf("\n");
  return 0;
}
