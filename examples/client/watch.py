import json
import subprocess

process = subprocess.Popen(["lss-cli", "--jsonl", "watch", "--for", "3s"], stdout=subprocess.PIPE, text=True)
for line in process.stdout:
    status = json.loads(line)
    if status.get("telemetry"):
        print(status["vehicle_id"], status["state"], f"{status['telemetry']['distance_m']:.3f} m")
