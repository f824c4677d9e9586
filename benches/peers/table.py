"""Lines of `name,robots,agent_steps,cpu_s` from standard input, as a Markdown table.

Of several runs of one program the fastest counts: others shared the core with somebody. Ratios are
to the plain loop with the same number of robots.
"""

import sys

YARDSTICK = "plain loop (Rust; f64)"
WORLD = "reference world"


def rate_text(rate):
    return f"{rate / 1e6:.1f} M" if rate >= 1e6 else f"{rate / 1e3:.1f} k"


def ratio_text(ratio):
    return f"{ratio:.1f} ×" if ratio >= 0.095 else f"1/{1 / ratio:,.0f} ×"


def main():
    rates = {}
    for line in sys.stdin:
        name, robots, agent_steps, cpu_s = line.rstrip("\n").rsplit(",", 3)
        rate = float(agent_steps) / float(cpu_s)
        of_size = rates.setdefault(int(robots), {})
        of_size[name] = max(rate, of_size.get(name, 0.0))
    print("| robots | program | agent-steps per CPU-second | to the plain loop |")
    print("|---:|---|---:|---:|")
    for robots, of_size in sorted(rates.items()):
        for name, rate in sorted(of_size.items(), key=lambda entry: entry[1]):
            ratio = ratio_text(rate / of_size[YARDSTICK]) if YARDSTICK in of_size else "–"
            print(f"| {robots:,} | {name} | {rate_text(rate)} | {ratio} |")
    large = {robots: rates[robots][WORLD] for robots in (1_000, 100_000) if robots in rates}
    if len(large) == 2:
        ratio = large[1_000] / large[100_000]
        print(f"\nIn a world of 100,000 a robot's step costs {ratio:.2f} times that in one of 1,000.")


if __name__ == "__main__":
    main()
