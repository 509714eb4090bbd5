//! Sends the head and the hands to Monado's remote driver, as a packet of 376 bytes fifty times a second.

use std::io::Write as _;
use std::process::{Child, Command, Stdio};
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Arc, Mutex};
use std::thread::JoinHandle;
use std::time::Duration;

/// A quaternion (x, y, z, w) and a position (x, y, z).
pub type Pose = [f32; 7];

pub const UPRIGHT: Pose = [0.0, 0.0, 0.0, 1.0, 0.0, 1.6, 0.0];

/// The state of one hand's controller.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Hand {
    pub pose: Pose,
    pub trigger: bool,
    pub b: bool,
    pub stick: [f32; 2],
    pub stick_click: bool,
}

/// Everything that a packet holds.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Hands {
    pub head: Pose,
    pub ipd_m: f32,
    /// The left eye's angles to the left, right, up and down, in radians. The right eye's are their mirror image.
    pub fov: [f32; 4],
    pub hands: [Hand; 2],
}

impl Default for Hands {
    fn default() -> Hands {
        // The hands hang down, so that they point at nothing.
        let down = [-0.707_106_77, 0.0, 0.0, 0.707_106_77];
        let hand = |x: f32| Hand {
            pose: [down[0], down[1], down[2], down[3], x, 1.0, -0.2],
            trigger: false,
            b: false,
            stick: [0.0; 2],
            stick_click: false,
        };
        Hands { head: UPRIGHT, ipd_m: 0.064, fov: [-0.87, 0.87, 0.87, -0.87], hands: [hand(-0.2), hand(0.2)] }
    }
}

impl Hands {
    fn packet(&self) -> Vec<u8> {
        let mut out = b"mndrmt3\0".to_vec();
        let mut put = |values: &[f32]| values.iter().for_each(|v| out.extend_from_slice(&v.to_le_bytes()));
        let [left, right, up, down] = self.fov;
        for (fov, x) in [([left, right, up, down], -0.5), ([-right, -left, up, down], 0.5)] {
            put(&fov);
            put(&[0.0, 0.0, 0.0, 1.0, x * self.ipd_m, 0.0, 0.0]);
            put(&[0.0]);
        }
        put(&self.head);
        out.extend_from_slice(&[1, 0, 0, 0]);
        for hand in &self.hands {
            let mut put = |values: &[f32]| values.iter().for_each(|v| out.extend_from_slice(&v.to_le_bytes()));
            put(&hand.pose);
            // The velocities, and then the fingers.
            put(&[0.0; 6]);
            put(&[0.0; 5]);
            put(&[f32::from(u8::from(hand.trigger)), 0.0, 0.0]);
            put(&hand.stick);
            put(&[0.0; 3]);
            let bit = u8::from;
            // One byte each: hand tracking, active, system (2), A (2), B (2), trigger (2), stick (2), pad, unused.
            out.extend_from_slice(&[0, 1, 0, 0, 0, 0, bit(hand.b), 0, bit(hand.trigger), 0]);
            out.extend_from_slice(&[bit(hand.stick_click), 0, 0, 0, 0, 0]);
        }
        assert_eq!(out.len(), 376);
        out
    }
}

/// A connection that keeps sending the state that was set last.
pub struct Remote {
    state: Arc<Mutex<Hands>>,
    /// The number of packets sent so far.
    sent: Arc<AtomicU64>,
    done: Arc<AtomicBool>,
    thread: Option<JoinHandle<()>>,
    relay: Child,
}

impl Remote {
    /// Connects to the driver, which listens in the network namespace of the process `service`.
    pub fn connect(service: u32) -> Remote {
        let state = Arc::new(Mutex::new(Hands::default()));
        let done = Arc::new(AtomicBool::new(false));
        let sent = Arc::new(AtomicU64::new(0));
        let (current, over, count) = (Arc::clone(&state), Arc::clone(&done), Arc::clone(&sent));
        // The relay is a process of its own in that network namespace. It sends its standard input to the driver.
        let relay = "until exec 3<>/dev/tcp/127.0.0.1/4242; do sleep 0.1; done 2>/dev/null; exec cat >&3";
        let mut command = Command::new("nsenter");
        command.arg(format!("--net=/proc/{service}/ns/net")).args(["bash", "-c", relay]);
        let mut relay = command.stdin(Stdio::piped()).stdout(Stdio::null()).spawn().expect("nsenter (util-linux)");
        let mut stream = relay.stdin.take().expect("a pipe");
        let send = move || {
            while !over.load(Ordering::Relaxed) {
                let packet = current.lock().unwrap().packet();
                if stream.write_all(&packet).is_err() {
                    return;
                }
                count.fetch_add(1, Ordering::Relaxed);
                std::thread::sleep(Duration::from_millis(20));
            }
        };
        Remote { state, sent, done, thread: Some(std::thread::spawn(send)), relay }
    }

    /// Changes the state that is sent from now on.
    pub fn set(&self, change: impl FnOnce(&mut Hands)) {
        change(&mut self.state.lock().unwrap());
    }

    /// Waits until `packets` packets with the state that was set last have been sent.
    pub fn sent(&self, packets: u64) {
        // The packet that is being written may still hold the state from before.
        let wanted = self.sent.load(Ordering::Relaxed) + packets + 1;
        super::wait_for("packets to the headset", Duration::from_secs(60), || {
            (self.sent.load(Ordering::Relaxed) >= wanted).then_some(())
        });
    }

    /// Changes the state for about a tenth of a second, which is long enough for several packets and frames.
    pub fn tap(&self, change: impl FnOnce(&mut Hands)) {
        let before = *self.state.lock().unwrap();
        self.set(change);
        std::thread::sleep(Duration::from_millis(120));
        *self.state.lock().unwrap() = before;
        std::thread::sleep(Duration::from_millis(120));
    }

    /// Pulls the right hand's trigger.
    pub fn trigger(&self) {
        self.tap(|h| h.hands[1].trigger = true);
    }

    /// Pushes the right hand's stick; +1 is to the right.
    pub fn stick(&self, by: i32) {
        self.tap(|h| h.hands[1].stick = [by as f32, 0.0]);
    }
}

impl Drop for Remote {
    fn drop(&mut self) {
        self.done.store(true, Ordering::Relaxed);
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
        let _ = self.relay.kill();
        let _ = self.relay.wait();
    }
}
